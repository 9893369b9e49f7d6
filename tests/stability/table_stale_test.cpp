// A table of the scene as it was: after a light moved, a wall went, a material changed. run_job()
// takes any table of the method; the command and the server check table_fits() first.
#include <gtest/gtest.h>

#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

constexpr int kStaleSide = 24;  // pixels

struct Change {
  const char* name;
  Scene before, after;  // of equal bounds, so that the table's grid is still this job's
};

std::vector<Change> changes() {
  std::vector<Change> list;
  Scene moved = test::room();
  for (Vec3& p : moved.meshes.back().positions) p = p + Vec3{-0.7f, 0, 0.6f};
  list.push_back({"light moved", test::room(), std::move(moved)});

  // A wall from floor to ceiling keeps the lamp's light from the left half.
  Scene walled = test::room();
  test::add_quad(walled, MaterialId(0), {-0.4f, 0, -1}, {0, 2, 0}, {0, 0, 1.7f});
  list.push_back({"wall removed", std::move(walled), test::room()});

  // The lamp shines on a screen only: what the walls' colour was decides all light.
  Scene painted = test::room(/*shaded=*/true);
  painted.materials[0].reflectance.value = Rgb{0.9f, 0.4f, 0.1f};
  painted.materials[1].kind = MaterialKind::kConductor;
  painted.materials[1].roughness.value = 0.2f;
  list.push_back({"material changed", test::room(/*shaded=*/true), std::move(painted)});
  return list;
}

// The noise of jobs that use, and do not change, what four passes made of `start`.
double error_after_four_passes(const PreparedScene& scene, RenderSettings settings,
                               const std::optional<TableFile>& start, const Image& reference) {
  constexpr int kSeeds = 48;
  std::vector<double> errors;
  RenderSettings learn = settings;
  learn.passes = {1, 1, 1, 1};
  settings.learning_samples = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    learn.seed = 700 + seed;
    settings.seed = seed;
    const std::optional<TableFile> table = test::render(scene, learn, start).job.table;
    errors.push_back(relmse(test::render(scene, settings, table).image, reference));
  }
  return test::median(errors);
}

TEST(TableStale, WarmIsUnbiasedAndRecovers) {
  const test::FailureMode mode("stale-table");
  for (Change& change : changes()) {
    const auto before = test::prepare(std::move(change.before));
    const auto after = test::prepare(std::move(change.after));
    RenderSettings settings = test::small_settings("none", kStaleSide, 16);
    const Image reference = test::reference_of(*after, settings, 64);
    const test::SeedOptions cold{.seeds = 48, .regions = 2, .table = {}};
    const test::Sampled none = test::sample_seeds(*after, settings, "none", cold, &reference);
    for (const std::string& name : test::learning_methods()) {
      settings = test::variant_settings(name, kStaleSide, 16);
      const TableFile stale = *test::learned_table(*before, settings, name, 256);
      ASSERT_FALSE(table_fits(stale.header, after->hash)) << change.name;
      test::SeedOptions warm = cold;
      warm.table = [&](const std::string&) { return stale; };
      test::check_method(mode, change.name,
                         test::sample_seeds(*after, settings, name, warm, &reference), none, &none);
      // Judged is `adaptive`; of the others the page tells.
      const bool judged = name.starts_with("adaptive");
      if (!judged && !test::FailureMode::reports()) continue;
      const double ratio = error_after_four_passes(*after, settings, stale, reference) /
                           error_after_four_passes(*after, settings, {}, reference);
      mode.error(name, std::string(change.name) + ", after 4 passes, over that of a cold start",
                 formatted("%.2f", ratio));
      if (judged) {
        // The ratio of two medians of 48 has noise of its own, some hundredths.
        EXPECT_LE(ratio, 1.1) << change.name;
      }
    }
  }
}

}  // namespace
}  // namespace qray
