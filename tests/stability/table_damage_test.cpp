// Tables that are not what they should be: of another scene, cut off anywhere, with any bit
// flipped, with any bit flipped and the checksums made right again.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/stability/failure_mode.h"
#include "tests/stability/huang_table.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

std::unique_ptr<Guide> guide_of(const PreparedScene& scene, const RenderSettings& settings) {
  return make_guide(settings.method, scene.guide_setup(settings)).value();
}

// As a job takes a file: decoded, then loaded into its guide.
Status take(std::span<const uint8_t> bytes, const PreparedScene& scene,
            const RenderSettings& settings) {
  Result<TableFile> table = decode_table(bytes);
  if (!table.ok()) return table.error();
  return guide_of(scene, settings)->load(table.value().sections);
}

bool is_honest(const Error& error) {
  return (error.code == ErrorCode::kCorrupt || error.code == ErrorCode::kUnsupported ||
          error.code == ErrorCode::kConflict || error.code == ErrorCode::kTooLarge) &&
         !error.message.empty() && error.where.starts_with("table");
}

// The smallest there is: about 20 states.
struct SmallTable {
  std::shared_ptr<const PreparedScene> scene = test::prepare(test::room());
  RenderSettings settings;
  TableFile table;

  explicit SmallTable(std::string_view method)
      : settings(test::small_settings(std::string(method), 8, 16)) {
    settings.huang.grid = 1;
    table = *test::learned_table(*scene, settings, method);
  }
};

TEST(TableDamage, CutOffOrWithAnyBitFlippedIsRefused) {
  const test::FailureMode mode("damaged-table");
  for (std::string_view method : method_names()) {
    if (method == "none") continue;
    const SmallTable small(method);
    const Bytes good = encode_table(small.table);
    ASSERT_TRUE(take(good, *small.scene, small.settings).ok());
    for (size_t size = 0; size < good.size(); ++size) {
      const Status taken = take(std::span(good).first(size), *small.scene, small.settings);
      ASSERT_TRUE(!taken.ok() && is_honest(taken.error())) << method << ", cut at " << size;
    }
    Bytes bad = good;
    for (size_t bit = 0; bit < good.size() * 8; ++bit) {
      const uint8_t mask = static_cast<uint8_t>(1u << (bit % 8));
      bad[bit / 8] ^= mask;
      const Status taken = take(bad, *small.scene, small.settings);
      ASSERT_TRUE(!taken.ok() && is_honest(taken.error())) << method << ", bit " << bit;
      bad[bit / 8] ^= mask;
    }
    mode.says(method,
              formatted("a file of %zu bytes is refused when it is cut to any of %zu lengths and "
                        "when any of its %zu bits is flipped",
                        good.size(), good.size(), good.size() * 8));
  }
}

// What a guide took must be a density: finite, positive where its samples fall.
void expect_usable(const Guide& guide, const std::string& where) {
  test::Random random(47);
  for (int i = 0; i < 12; ++i) {
    const Vec3 p{-1 + 2 * random.next(), 2 * random.next(), -1 + 2 * random.next()};
    Vec3 n;
    n[i % 3] = i % 2 == 0 ? 1.0f : -1.0f;
    const GuidePoint point = guide.find(p, n);
    if (guide.mixture(point, {}).guide == 0) continue;  // it is not asked there
    const GuideSample s = guide.sample(point, random.next_2d());
    ASSERT_TRUE(std::isfinite(s.pdf_w) && s.pdf_w > 0 && std::abs(length(s.wi) - 1) < 1e-4f)
        << where << ": " << s.pdf_w;
  }
}

TEST(TableDamage, RightChecksumsOverWrongBitsAreRefusedOrHarmless) {
  const test::FailureMode mode("damaged-table");
  for (std::string_view method : method_names()) {
    if (method == "none") continue;
    const SmallTable small(method);
    int refused = 0, taken = 0;
    std::vector<TableSection> sections = small.table.sections;
    for (TableSection& section : sections)
      for (size_t bit = 0; bit < section.bytes.size() * 8; ++bit) {
        // All of the first KiB; of the rest, which repeats it, a share without a pattern.
        if (bit >= 8192 && bit % 13 != 0) continue;
        const uint8_t mask = static_cast<uint8_t>(1u << (bit % 8));
        section.bytes[bit / 8] ^= mask;
        const std::unique_ptr<Guide> guide = guide_of(*small.scene, small.settings);
        const Status loaded = guide->load(sections);
        const std::string where = section.tag + formatted(", bit %zu", bit);
        if (loaded.ok()) {
          ++taken;
          expect_usable(*guide, where);
        } else {
          ++refused;
          EXPECT_TRUE(is_honest(loaded.error())) << where << ": " << loaded.error().text();
        }
        section.bytes[bit / 8] ^= mask;
      }
    EXPECT_GT(refused, 0) << method;
    EXPECT_GT(taken, 0) << method;
    mode.says(method,
              formatted("of bits flipped under right checksums %d are refused and %d are taken "
                        "as other finite values",
                        refused, taken));
  }
}

TEST(TableDamage, AnotherScenesTableIsNotTaken) {
  const SmallTable small("huang");
  Scene geometry = small.scene->scene, materials = geometry, lights = geometry;
  geometry.meshes[1].positions[0].y += 0.01f;
  materials.materials[0].reflectance.value = Rgb{0.6f};
  lights.materials[2].emission.value = Rgb{1};
  EXPECT_TRUE(table_fits(small.table.header, small.scene->hash));
  for (Scene* scene : {&geometry, &materials, &lights})
    EXPECT_FALSE(table_fits(small.table.header, test::prepare(*scene)->hash));

  // Where nobody looks at the hashes, the grid and the method still must be the job's.
  RenderSettings settings = small.settings;
  settings.huang.grid = 2;
  const auto other_grid = test::try_render(*small.scene, settings, small.table);
  ASSERT_FALSE(other_grid.ok());
  EXPECT_EQ(other_grid.error().code, ErrorCode::kConflict);
  settings.method = "none";
  const auto no_guide = test::try_render(*small.scene, settings, small.table);
  ASSERT_FALSE(no_guide.ok());
  EXPECT_EQ(no_guide.error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace qray
