// A table at its memory cap: no new states, no bias, the same bits for any number of threads; and a
// table that does not fit is refused.
#include <gtest/gtest.h>

#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

constexpr int kCapSide = 24;                      // pixels
constexpr size_t kCaps[] = {1, 64'000, 400'000};  // bytes: no room at all, for few, for many states

test::Rendered with_threads(const PreparedScene& scene, const RenderSettings& settings,
                            int threads) {
  Film film(settings.width, settings.height);
  TaskPool pool(threads);
  RenderObserver observer;
  Result<JobResult> job = run_job(scene, settings, {}, film, pool, observer, {}, SteadyClock());
  EXPECT_TRUE(job.ok());
  return {film.develop(), std::move(job).value()};
}

// Bytes of the table that the job leaves where nothing holds it back.
size_t wants(const PreparedScene& scene, RenderSettings settings) {
  settings.max_table_bytes = kDefaultTableBytes;
  return test::render(scene, settings).job.stats.table_bytes;
}

TEST(TableCap, AddsNoStatesAndStaysUnbiased) {
  const test::FailureMode mode("table-cap");
  const auto scene = test::prepare(test::room());
  for (size_t cap : kCaps) {
    RenderSettings settings = test::small_settings("none", kCapSide, 16);
    settings.max_table_bytes = cap;
    const std::string label = formatted("cap of %zu byte%s", cap, cap == 1 ? "" : "s");
    for (const std::string& method : test::learning_methods()) {
      RenderSettings of_method = test::variant_settings(method, kCapSide, 16);
      of_method.max_table_bytes = cap;
      const RenderStats stats = test::render(*scene, of_method).job.stats;
      EXPECT_LE(stats.table_bytes, cap) << method << ", " << label;
      if (wants(*scene, of_method) > cap) {
        EXPECT_GT(stats.table_refused, 0u) << method << ", " << label;
      }
      EXPECT_EQ(stats.states == 0, cap == 1) << method << ", " << label;
      mode.says(method, formatted("with a %s its table has %zu states in %zu bytes", label.c_str(),
                                  stats.states, stats.table_bytes));
    }
    test::SeedOptions options;
    options.guide_rules = cap > 1;
    options.table = [&](const std::string& method) {
      return test::learned_table(*scene, settings, method);
    };
    test::check_methods(mode, label, *scene, settings, options);
  }
}

TEST(TableCap, BoundsTheMemoryOfAnyTable) {
  // Each facet of a sphere has a normal, so a state, of its own: the most memory a state takes.
  Scene scene = test::room();
  Mesh ball;
  ball.material = MaterialId(0);
  constexpr uint32_t kRings = 40, kSectors = 80;
  for (uint32_t i = 0; i <= kRings; ++i)
    for (uint32_t j = 0; j <= kSectors; ++j) {
      const float theta = kPi * static_cast<float>(i) / kRings;
      const float phi = 2 * kPi * static_cast<float>(j) / kSectors;
      ball.positions.push_back(Vec3{-0.4f, 0.9f, 0} + Vec3{std::sin(theta) * std::cos(phi),
                                                           std::cos(theta),
                                                           std::sin(theta) * std::sin(phi)} *
                                                          0.4f);
    }
  for (uint32_t i = 0; i < kRings; ++i)
    for (uint32_t j = 0; j < kSectors; ++j) {
      const uint32_t a = i * (kSectors + 1) + j, b = a + kSectors + 1;
      ball.triangles.push_back({a, a + 1, b});
      ball.triangles.push_back({a + 1, b + 1, b});
    }
  scene.meshes.push_back(ball);
  const auto prepared = test::prepare(std::move(scene));
  for (std::string_view method : method_names()) {
    if (method == "none") continue;
    RenderSettings settings = test::small_settings(std::string(method), 48, 64);
    settings.huang.grid = 64;
    settings.adaptive.split_samples = 300;
    size_t without_cap = 0;
    for (size_t part : {0, 3, 20, 90}) {  // 0: all that it wants
      const size_t cap = part == 0 ? kDefaultTableBytes : without_cap / part;
      settings.max_table_bytes = cap;
      const RenderStats stats = test::render(*prepared, settings).job.stats;
      EXPECT_LE(stats.table_bytes, cap) << method;
      if (part == 0) {
        without_cap = stats.table_bytes;
        EXPECT_EQ(stats.table_refused, 0u) << method;
        EXPECT_GT(without_cap, 20'000u) << method;
      } else {
        EXPECT_GT(stats.table_refused, 0u) << method << ", a part in " << part;
        if (cap > 50'000) {
          EXPECT_GT(stats.table_bytes, cap / 5) << method << ": the cap should be used";
        }
      }
    }
  }
}

TEST(TableCap, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto scene = test::prepare(test::room());
  for (const std::string& method : test::learning_methods()) {
    RenderSettings settings = test::variant_settings(method, 64, 16);
    settings.max_table_bytes = wants(*scene, settings) / 2;
    const test::Rendered one = with_threads(*scene, settings, 1);
    const test::Rendered three = with_threads(*scene, settings, 3);
    EXPECT_GT(one.job.stats.table_refused, 0u);
    EXPECT_EQ(one.job.stats.table_refused, three.job.stats.table_refused);
    EXPECT_EQ(one.job.table->header.id, three.job.table->header.id) << method;
    EXPECT_TRUE(std::ranges::equal(one.image.data(), three.image.data())) << method;
  }
}

TEST(TableCap, ATableOverTheCapIsRefused) {
  const test::FailureMode mode("table-cap");
  const auto scene = test::prepare(test::room());
  for (std::string_view method : method_names()) {
    if (method == "none") continue;
    RenderSettings settings = test::small_settings(std::string(method), kCapSide, 16);
    settings.adaptive.split_samples = 300;  // so that there is something to refuse
    settings.max_table_bytes = wants(*scene, settings);
    const TableFile table = *test::learned_table(*scene, settings, method);
    EXPECT_TRUE(test::try_render(*scene, settings, table).ok()) << "at its own cap";
    settings.max_table_bytes /= 3;
    const Result<test::Rendered> refused = test::try_render(*scene, settings, table);
    ASSERT_FALSE(refused.ok()) << method;
    EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge) << method;
    const std::string& told = refused.error().message;
    EXPECT_NE(told.find(std::to_string(settings.max_table_bytes) + " bytes"), std::string::npos)
        << told;
    if (test::is_huang(method)) {
      EXPECT_NE(told.find(std::to_string(test::huang_states(table).size()) + " states"),
                std::string::npos)
          << told;
    }
    mode.says(method, "refuses a table over its cap: \"" + told + "\"");
  }
}

}  // namespace
}  // namespace qray
