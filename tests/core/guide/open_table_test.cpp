// Tables without their scene: opened, checked, merged.
#include "core/guide/open_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "core/guide/dahm_keller.h"
#include "core/guide/grid_table.h"
#include "core/guide/huang.h"
#include "core/math/warp.h"
#include "tests/core/guide/taught.h"

namespace qray {
namespace {

using test::setup_of, test::taught;

const char* const kMethods[] = {"huang", "dahm-keller", "ppg", "adaptive"};
const char* const kMergeable[] = {"huang", "dahm-keller", "adaptive"};

TableFile table_of(const Guide& guide) {
  TableFile table;
  table.header.method = guide.method();
  table.header.program = "test";
  table.header.samples_seen = guide.stats().samples_seen;
  table.sections = guide.save();
  table.header.id = table_id(table);
  return table;
}

TableFile table_of(std::string_view method, uint64_t seed, const GuideSetup& setup = setup_of()) {
  return table_of(*taught(method, seed, setup));
}

bool same_sections(const std::vector<TableSection>& a, const std::vector<TableSection>& b) {
  return std::ranges::equal(a, b, [](const TableSection& x, const TableSection& y) {
    return x.tag == y.tag && x.bytes == y.bytes;
  });
}

// Of one direction a state, by key.
std::map<uint64_t, float> densities(const Guide& guide, uint64_t seed = 1) {
  std::map<uint64_t, float> result;
  for (const GuidePoint& point : guide.known_points(100'000)) {
    test::Random random(point.key + seed);
    const Vec3 local = square_to_cosine_hemisphere(random.next_2d());
    result[point.key] = guide.pdf_w(point, point.frame.to_world(local));
  }
  return result;
}

void expect_error(const Error& error, ErrorCode code, const std::string& says) {
  EXPECT_EQ(error.code, code) << error.text();
  EXPECT_NE(error.text().find(says), std::string::npos) << error.text();
}

TEST(OpenTable, SavedOpenedAndSavedAgainItIsTheSameFile) {
  for (const char* method : kMethods)
    for (int grid : {1, 32, 100}) {
      const TableFile table = table_of(method, 1, setup_of(grid));
      const auto opened = open_table(table, kDefaultTableBytes);
      ASSERT_TRUE(opened.ok()) << method << ": " << opened.error().text();
      EXPECT_EQ(opened.value()->method(), method);
      EXPECT_TRUE(same_sections(opened.value()->save(), table.sections)) << method;
    }
}

TEST(OpenTable, RefusesWhatNoGuideReads) {
  TableFile table = table_of("huang", 1);
  table.header.method = "none";
  expect_error(open_table(table, kAnyTableBytes).error(), ErrorCode::kUnsupported, "none");
  table = table_of("huang", 1);
  EXPECT_EQ(open_table(table, 1000).error().code, ErrorCode::kTooLarge);
  table.sections.clear();
  EXPECT_EQ(open_table(table, kAnyTableBytes).error().code, ErrorCode::kCorrupt);
  table = table_of("huang", 1);
  table.sections[0].bytes[7] = 0x7f;  // cells of 2^(9e18) m
  EXPECT_EQ(open_table(table, kAnyTableBytes).error().code, ErrorCode::kCorrupt);
}

TEST(CheckTable, GoodTablesAreGood) {
  for (const char* method : kMethods) {
    const TableFile table = table_of(method, 1);
    const auto check = check_table(table);
    ASSERT_TRUE(check.ok()) << method << ": " << check.error().text();
    EXPECT_EQ(check.value().densities, check.value().guide->known_points(32).size());
    EXPECT_NEAR(check.value().worst, 1, 0.005) << method;
  }
}

TEST(CheckTable, NamesEachKindOfDamage) {
  const TableFile good = table_of("dahm-keller", 1);
  TableFile bad = good;
  bad.header.id[0] = bad.header.id[0] == 'a' ? 'b' : 'a';
  expect_error(check_table(bad).error(), ErrorCode::kCorrupt, "the id is");
  const auto told = [](TableFile table) {  // of a table whose id is right
    table.header.id = table_id(table);
    const auto check = check_table(table);
    EXPECT_FALSE(check.ok());
    return check.ok() ? Error{} : check.error();
  };
  bad = good;
  ++bad.header.samples_seen;
  expect_error(told(bad), ErrorCode::kCorrupt, "samples seen");
  bad = good;
  bad.sections[1].bytes.pop_back();
  expect_error(told(bad), ErrorCode::kCorrupt, "table:DQ64: wrong size");
  bad = good;
  std::swap(bad.sections[0], bad.sections[1]);
  expect_error(told(bad), ErrorCode::kCorrupt, "table: expected");
  constexpr size_t kSecond = 8 + 8 + DahmKellerGuide::kCells * 8;  // the second state's key
  bad = good;
  std::copy_n(good.sections[1].bytes.begin() + 8, 8, bad.sections[1].bytes.begin() + kSecond);
  expect_error(told(bad), ErrorCode::kCorrupt, "table:DQ64, state 1");
  ByteWriter number;
  for (float value : {-1.0f, std::numeric_limits<float>::infinity(), std::nanf("")}) {
    bad = good;
    number = {};
    number.f32(value);
    std::ranges::copy(number.data(), bad.sections[1].bytes.begin() + kSecond + 8);
    expect_error(told(bad), ErrorCode::kCorrupt, "table:DQ64, state 1");
  }
}

// A guide whose density says `factor` times what it samples.
class Wrong final : public GuideSampler {
 public:
  explicit Wrong(float factor) : factor_(factor) {}
  bool unbiased() const override { return false; }
  GuidePoint find(Vec3, Vec3) const override { return {}; }
  GuideMixture mixture(const GuidePoint&, const GuidedSurface&) const override {
    return GuideMixture::of(1);
  }
  GuideSample sample(const GuidePoint& point, Vec2 u) const override {
    const Vec3 wi = square_to_cosine_hemisphere(u);
    return {wi, pdf_w(point, wi)};
  }
  float pdf_w(const GuidePoint&, Vec3 wi) const override {
    return factor_ * cosine_hemisphere_pdf_w(wi.z);
  }

 private:
  float factor_;
};

// A guide that draws from the whole sphere.
class Everywhere final : public GuideSampler {
 public:
  bool unbiased() const override { return true; }
  GuidePoint find(Vec3, Vec3) const override { return {}; }
  GuideMixture mixture(const GuidePoint&, const GuidedSurface&) const override {
    return GuideMixture::of(1);
  }
  GuideSample sample(const GuidePoint&, Vec2 u) const override {
    return {square_to_uniform_sphere(u), kUniformSpherePdfW};
  }
  float pdf_w(const GuidePoint&, Vec3) const override { return kUniformSpherePdfW; }
};

TEST(CheckTable, TheIntegralIsOverThePointsDomain) {
  GuidePoint point;
  EXPECT_NEAR(density_integral(Everywhere(), point), 0.5, 1e-3);
  point.domain = GuideDomain::kSphere;
  EXPECT_NEAR(density_integral(Everywhere(), point), 1, 1e-3);
}

TEST(CheckTable, DensitiesThatDoNotIntegrateToOneShow) {
  EXPECT_NEAR(density_integral(Wrong(1), {}), 1, 1e-3);
  EXPECT_GT(density_integral(Wrong(1.05f), {}), 1.01);
  EXPECT_LT(density_integral(Wrong(0.95f), {}), 0.99);
}

TEST(MergeTables, EitherOrderGivesTheSameBytes) {
  for (const char* method : kMergeable) {
    const auto a = taught(method, 1, setup_of()), b = taught(method, 2, setup_of());
    const TableFile file_a = table_of(*a), file_b = table_of(*b);
    ASSERT_FALSE(same_sections(file_a.sections, file_b.sections));
    const auto ab = taught(method, 1, setup_of()), ba = taught(method, 2, setup_of());
    ASSERT_TRUE(ab->merge(*b).ok());
    ASSERT_TRUE(ba->merge(*a).ok());
    EXPECT_TRUE(same_sections(ab->save(), ba->save())) << method;
    EXPECT_EQ(ab->stats().samples_seen, a->stats().samples_seen + b->stats().samples_seen);
    // And what is merged rules sampling at once, as if it had been loaded.
    const auto loaded = make_guide(method, setup_of()).value();
    ASSERT_TRUE(loaded->load(ab->save()).ok());
    const std::map<uint64_t, float> sampled = densities(*ab);
    EXPECT_EQ(sampled, densities(*loaded)) << method;
    for (const TableFile* one : {&file_a, &file_b}) {
      const auto alone = make_guide(method, setup_of()).value();
      ASSERT_TRUE(alone->load(one->sections).ok());
      EXPECT_GT(sampled.size(), densities(*alone).size()) << method;
    }
    EXPECT_NE(sampled, densities(*loaded, 7)) << method;

    const TableFile both[] = {file_a, file_b}, turned[] = {file_b, file_a};
    const auto merged = merge_tables(both, kDefaultTableBytes);
    ASSERT_TRUE(merged.ok()) << merged.error().text();
    const TableFile& file = merged.value().file;
    EXPECT_EQ(encode_table(file),
              encode_table(merge_tables(turned, kDefaultTableBytes).value().file));
    EXPECT_TRUE(same_sections(file.sections, ab->save()));
    EXPECT_TRUE(check_table(file).ok());
    EXPECT_EQ(merged.value().states, ab->stats().states);
    const TableHeader& header = file.header;
    std::vector<std::string> parents{file_a.header.id, file_b.header.id};
    std::ranges::sort(parents);
    EXPECT_EQ(header.parents, parents);
    EXPECT_EQ(header.samples_seen, file_a.header.samples_seen + file_b.header.samples_seen);
  }
}

TEST(MergeTables, CellsBecomeTheMeanOfAllUpdates) {
  float value = 2;
  uint32_t count = 3;
  merge_cell(value, count, 6, 1);
  EXPECT_EQ(value, 3);
  EXPECT_EQ(count, 4u);
  merge_cell(value, count, 9, 0);
  EXPECT_EQ(value, 3);
  merge_cell(value, count, 3, ~0u);
  EXPECT_EQ(count, ~0u);
  // Products that a fused multiply-add would round on one side only.
  test::Random random(5);
  for (int i = 0; i < 100'000; ++i) {
    const float a = random.next() * 1e3f, b = random.next();
    const uint32_t n = static_cast<uint32_t>(random.next() * 4e9f),
                   m = static_cast<uint32_t>(random.next() * 4e9f);
    float x = a, y = b;
    uint32_t k = n, l = m;
    merge_cell(x, k, b, m);
    merge_cell(y, l, a, n);
    ASSERT_EQ(x, y);
    ASSERT_EQ(k, l);
  }
}

TEST(MergeTables, RefusesTablesThatDoNotBelongTogether) {
  const TableFile a = table_of("huang", 1);
  const auto error_of = [&](const TableFile& b, size_t max_bytes = kDefaultTableBytes) {
    const TableFile tables[] = {a, b};
    const auto merged = merge_tables(tables, max_bytes);
    EXPECT_FALSE(merged.ok());
    return merged.ok() ? Error{} : merged.error();
  };
  TableFile b = table_of("huang", 2);
  b.header.materials.bytes[0] ^= 1;
  b.header.lights.bytes[0] ^= 1;
  expect_error(error_of(b), ErrorCode::kConflict, "materials, lights");
  expect_error(error_of(table_of("dahm-keller", 2)), ErrorCode::kConflict, "method");
  expect_error(error_of(table_of("huang", 2, setup_of(8))), ErrorCode::kConflict, "grid");
  expect_error(error_of(a), ErrorCode::kInvalid, "twice");
  EXPECT_EQ(merge_tables({&a, 1}, kDefaultTableBytes).error().code, ErrorCode::kInvalid);
  // Memory for either, and not for both.
  b = table_of("huang", 77);
  size_t fits = 50'000;
  while (!open_table(a, fits).ok() || !open_table(b, fits).ok()) fits += 1000;
  expect_error(error_of(b, fits), ErrorCode::kTooLarge, "bytes of memory");
}

TEST(MergeTables, PpgsTablesHoldNoWeights) {
  const TableFile tables[] = {table_of("ppg", 1), table_of("ppg", 2)};
  const auto merged = merge_tables(tables, kDefaultTableBytes);
  ASSERT_FALSE(merged.ok());
  expect_error(merged.error(), ErrorCode::kInvalid, "'ppg' cannot be merged");
  const auto ppg = taught("ppg", 1, setup_of());
  EXPECT_EQ(ppg->merge(*taught("huang", 1, setup_of())).error().code, ErrorCode::kInvalid);
}

// What views show is what is drawn from.
TEST(Directions, HaveTheirDensities) {
  for (const char* method : kMethods) {
    const std::unique_ptr<Guide> guide = taught(method, 3, setup_of());
    size_t most = 0;
    for (const GuidePoint& point : guide->known_points(40)) {
      const std::vector<DirectionCell> cells = guide->directions(point);
      double area = 0;
      for (const DirectionCell& cell : cells) {
        area += static_cast<double>(sqr(cell.size));
        EXPECT_NEAR(dot(cell.wi, cell.wi), 1, 1e-4) << method;
        const float pdf_w = guide->pdf_w(point, cell.wi);
        // The thesis' directions at the horizon may lie below it.
        if (cell.size == 0 && dot(cell.wi, point.frame.z) < 1e-3f) continue;
        EXPECT_NEAR(cell.pdf_w, pdf_w, 2e-3f * (1 + pdf_w)) << method;
      }
      EXPECT_NEAR(area, std::string_view(method) == "huang" ? 0 : 1, 1e-6) << method;
      most = std::max(most, cells.size());
      const StateSummary summary = guide->summary(point);
      EXPECT_GT(summary.size_m, 0) << method;
      EXPECT_LE(summary.size_m, 16) << method;
      EXPECT_EQ(summary.visits.has_value(), std::string_view(method) != "ppg");
      EXPECT_GT(summary.visits.value_or(1), 0u) << method;
    }
    EXPECT_GT(most, 12u) << method;
  }
}

}  // namespace
}  // namespace qray
