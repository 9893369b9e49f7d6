// What the thesis' update makes of a table: the largest future value in place of the expected one,
// values that have no end, learning rates and discounts at their ends.
#include <gtest/gtest.h>

#include <cmath>

#include "core/math/warp.h"
#include "core/render/path.h"
#include "core/settings/variant.h"
#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

constexpr int kValuesSide = 24;  // pixels

// A closed 2 m room with a block in it under a small lamp. The lamp hangs low: in the ceiling's
// grid cell it would be the same state as the ceiling.
Scene closed_room(float albedo, float lamp_albedo) {
  Scene scene = test::room();
  for (Vec3& p : scene.meshes.back().positions) p.y = 1.4f;
  for (Material& m : scene.materials) m.reflectance.value = Rgb{m.emits() ? lamp_albedo : albedo};
  return scene;
}

float lamp_luminance(const Scene& scene) {
  float most = 0;
  for (const Material& m : scene.materials) most = std::max(most, luminance(m.emission.value));
  return most;
}

struct Seen {
  double learned = 0,
         truth = 0;  // luminance, the mean over directions without a lamp in their cell
};

// What arrives at points of the floor, and what the table holds in its place.
Seen seen_from_floor(const PreparedScene& scene, const RenderSettings& settings,
                     const TableFile& table) {
  constexpr int kPoints = 16, kRays = 20'000;
  HuangGuide guide(HuangGuide::Density::kExact, scene.bounds, settings.huang);
  EXPECT_TRUE(guide.load(table.sections).ok());
  PathTracer tracer(scene, scene.lights, settings, nullptr);
  test::Random random(37);
  Sampler sampler(41);
  const double lamp = static_cast<double>(lamp_luminance(scene.scene));
  Seen seen;
  double count = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    const Vec3 p{-0.9f + random.next() * 0.9f, 0, random.next() * 0.9f},
        n{0, 1, 0};  // off the block
    const HuangGuide::Values* values = guide.values(guide.find(p, n).key);
    if (!values) continue;
    std::array<double, kDirections26> sum{}, rays{};
    std::array<bool, kDirections26> lit{};
    for (uint32_t k = 0; k < kRays; ++k) {
      const Vec3 d = square_to_uniform_hemisphere(random.next_2d());
      const Vec3 up{d.x, d.z, d.y};
      const size_t a = static_cast<size_t>(nearest_direction26(up));
      sampler.start(i, 0, k);
      Rgb radiance;
      tracer.sample({p + n * 1e-3f, up}, sampler, nullptr, 0, {&radiance});
      tracer.flush();
      const double l = static_cast<double>(luminance(radiance));
      lit[a] = lit[a] || l > 0.9 * lamp;
      sum[a] += l;
      ++rays[a];
    }
    for (size_t a = 0; a < kDirections26; ++a) {
      if (lit[a]) continue;
      seen.truth += sum[a];
      seen.learned += rays[a] * static_cast<double>((*values)[a]);
      count += rays[a];
    }
  }
  EXPECT_GT(count, kPoints * kRays / 4) << "too few states were learned";
  return {seen.learned / count, seen.truth / count};
}

TEST(TableValues, MaxBackupOverestimates) {
  const test::FailureMode mode("max-backup");
  const auto scene = test::prepare(closed_room(0.2f, 0));
  double first_error = 0;  // of huang, at gamma 0.2
  for (float gamma : {0.2f, 1.0f}) {
    RenderSettings settings = test::small_settings("none", kValuesSide, 16);
    settings.nee = false;
    settings.huang.gamma = gamma;
    settings.huang.grid = 8;
    settings.learning_samples = 256;
    RenderSettings truth = settings;
    truth.nee = true;
    const std::optional<TableFile> table = test::learned_table(*scene, settings, "huang", 1024);
    const Seen seen = seen_from_floor(*scene, truth, *table);
    const double ratio = seen.learned / seen.truth;
    EXPECT_GT(ratio, gamma < 1 ? 2 : 20);
    mode.says("huang",
              formatted("with gamma %g the table holds %.3f where %.3f arrives, %.1f times as much",
                        double{gamma}, seen.learned, seen.truth, ratio));

    const test::SeedOptions cold{.seeds = 24, .regions = 2, .table = {}};
    test::SeedOptions warm = cold;
    warm.table = [&](const std::string& method) {
      return test::is_huang(method) ? table : test::learned_table(*scene, settings, method, 1024);
    };
    const Image reference = test::reference_of(*scene, truth, 64);
    const test::Sampled none = test::sample_seeds(*scene, settings, "none", cold, &reference);
    double huang_error = 0;
    // What has no gamma would only repeat itself.
    for (const std::string& method : gamma < 1 ? test::huang_methods() : test::learning_methods()) {
      const test::Sampled sampled = test::sample_seeds(*scene, settings, method, warm, &reference);
      test::check_method(mode, formatted("gamma %g", double{gamma}), sampled, none, &none);
      if (method == "huang") huang_error = test::median(sampled.relmse);
      if (gamma == 1 && method.starts_with("adaptive")) {  // no max there
        EXPECT_LT(test::median(sampled.relmse), huang_error) << method;
      }
    }
    if (gamma < 1) first_error = huang_error;
    if (gamma == 1) {
      EXPECT_GT(huang_error, 1.2 * first_error) << "values without difference should cost noise";
    }
  }
}

// Four jobs, each from the table of the one before, in a scene where nothing is absorbed but by a
// black lamp.
std::optional<TableFile> chained_table(const test::FailureMode& mode, const PreparedScene& scene,
                                       RenderSettings settings, const std::string& method,
                                       bool black_lamp) {
  const float lamp = lamp_luminance(scene.scene);
  settings = apply_variant(method, std::move(settings)).value();
  settings.samples = 256;
  settings.max_depth = 32;
  std::optional<TableFile> table;
  std::string largest_values;
  float last = lamp;
  for (int job = 1; job <= 4; ++job) {
    settings.seed = 500 + static_cast<uint64_t>(job);
    const test::Rendered r = test::render(scene, settings, table);
    EXPECT_EQ(r.job.stats.dropped_samples, 0u);
    for (float v : r.image.data()) EXPECT_TRUE(std::isfinite(v));
    table = r.job.table;
    if (!test::is_huang(method)) continue;
    const float largest = test::largest_value(*table);
    if (black_lamp) {
      EXPECT_LE(largest, lamp * 1.0001f);
    } else {
      EXPECT_LE(largest,
                settings.huang.alpha * lamp * static_cast<float>(table->header.samples_seen));
      EXPECT_GT(largest, last) << "the failure is gone: say so";
    }
    last = largest;
    largest_values += formatted("%s%.3g", job > 1 ? ", " : "", static_cast<double>(largest / lamp));
  }
  if (!largest_values.empty())
    mode.says(method,
              formatted("with a %s lamp the largest value after jobs 1 to 4 is %s times the "
                        "lamp's radiance",
                        black_lamp ? "black" : "white", largest_values.c_str()));
  return table;
}

TEST(TableValues, GammaOneAndAlbedoOne) {
  const test::FailureMode mode("gamma-one");
  for (bool black_lamp : {true, false}) {
    const std::string label = black_lamp ? "black lamp" : "white lamp";
    const auto scene = test::prepare(closed_room(1, black_lamp ? 0.0f : 1.0f));
    RenderSettings settings = test::small_settings("none", kValuesSide, 16);
    settings.huang.gamma = 1;
    settings.huang.alpha = 0.2f;
    settings.huang.grid = 8;
    settings.learning_samples = 64;
    std::map<std::string, std::optional<TableFile>> tables;
    for (const std::string& method : test::learning_methods())
      tables[method] = chained_table(mode, *scene, settings, method, black_lamp);
    const test::SeedOptions options{
        .seeds = 32, .regions = 2, .table = [&](const std::string& method) {
          return tables[method];
        }};
    settings.max_depth = 3;
    test::check_methods(mode, label + ", depth 3", *scene, settings, options);

    // Deep, weights multiply 31 times: the mean is right, but no number of samples here shows it.
    settings.max_depth = 32;
    const Image reference = test::reference_of(*scene, settings, 16);
    const auto errors = [&](std::string_view method) {
      const test::SeedOptions few{.seeds = 8, .regions = 2, .table = options.table};
      const test::Sampled s = test::sample_seeds(*scene, settings, method, few, &reference);
      EXPECT_EQ(s.dropped_samples, 0u) << method;
      return test::median(s.relmse);
    };
    const double none = errors("none");
    for (const std::string& method : test::learning_methods())
      mode.error(method, label + ", depth 32, median alone",
                 formatted("%.3g", errors(method) / none));
  }
}

TEST(TableValues, AlphaAndGammaAtTheirEnds) {
  const test::FailureMode mode("alpha-and-gamma-ends");
  const auto scene = test::prepare(test::room());
  const float lamp = lamp_luminance(scene->scene);
  RenderSettings usual = test::small_settings("huang", kValuesSide, 16);
  const TableFile taught = *test::learned_table(*scene, usual, "huang");
  for (float alpha : {0.0f, 1.0f})
    for (float gamma : {0.0f, 1.0f}) {
      RenderSettings settings = usual;
      settings.huang.alpha = alpha;
      settings.huang.gamma = gamma;
      const TableFile table = *test::learned_table(*scene, settings, "huang");
      if (alpha == 0) {
        EXPECT_EQ(test::largest_value(table), 0);
        const TableFile again = *test::render(*scene, settings, taught).job.table;
        std::map<uint64_t, HuangGuide::Values> after;
        for (const test::HuangState& state : test::huang_states(again)) after[state.key] = state.q;
        for (const test::HuangState& state : test::huang_states(taught))
          EXPECT_EQ(after[state.key], state.q);
        EXPECT_GT(again.header.samples_seen, taught.header.samples_seen);
      } else if (gamma == 0) {
        for (const test::HuangState& state : test::huang_states(table))
          for (float q : state.q) EXPECT_TRUE(q == 0 || q == lamp) << q;
        EXPECT_EQ(test::largest_value(table), lamp);
      }
      test::SeedOptions options;
      options.methods = test::huang_methods();
      options.table = [&](const std::string& method) {
        return test::learned_table(*scene, settings, method);
      };
      test::check_methods(mode, formatted("alpha %g, gamma %g", double{alpha}, double{gamma}),
                          *scene, settings, options);
    }
}

}  // namespace
}  // namespace qray
