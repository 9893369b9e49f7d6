// Values of 1e6 that no light justifies, written into a table: the picture keeps its mean, pays in
// noise, and the table forgets them.
#include <gtest/gtest.h>

#include "core/guide/surface_grid.h"
#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

constexpr int kFireflySide = 24;  // pixels
constexpr float kFirefly = 1e6f;

// One value of the state that learned the most, or of every state, in a direction above the
// surface.
TableFile with_fireflies(TableFile table, bool everywhere) {
  std::vector<test::HuangState> states = test::huang_states(table);
  const auto updates = [](const test::HuangState& s) {
    uint64_t sum = 0;
    for (uint32_t count : s.count) sum += count;
    return sum;
  };
  size_t busiest = 0;
  for (size_t i = 0; i < states.size(); ++i)
    if (updates(states[i]) > updates(states[busiest])) busiest = i;
  test::Random random(43);
  for (size_t i = 0; i < states.size(); ++i) {
    if (!everywhere && i != busiest) continue;
    size_t a = 0;
    do {
      a = random.next_u32() % kDirections26;
    } while (dot(directions26()[a], SurfaceGrid::normal_of(states[i].key)) < 0.3f);
    states[i].q[a] = kFirefly;
  }
  test::set_huang_states(table, states);
  return table;
}

// Grows a file's bytes from it and back, as a job from disk would get it.
TableFile through_bytes(const TableFile& table) {
  Result<TableFile> read = decode_table(encode_table(table));
  EXPECT_TRUE(read.ok());
  return read.value();
}

TEST(TableFirefly, KeepsTheMeanAndCostsNoise) {
  const test::FailureMode mode("firefly-in-a-table");
  const auto scene = test::prepare(test::room(/*shaded=*/true));
  const RenderSettings settings = test::small_settings("none", kFireflySide, 16);
  const Image reference = test::reference_of(*scene, settings, 64);
  const test::SeedOptions cold{.seeds = 48, .regions = 2, .table = {}};
  const test::Sampled none = test::sample_seeds(*scene, settings, "none", cold, &reference);
  for (const std::string& method : test::huang_methods()) {
    const TableFile clean = *test::learned_table(*scene, settings, method);
    const auto sample = [&](const TableFile& table) {
      test::SeedOptions warm = cold;
      warm.table = [&](const std::string&) { return through_bytes(table); };
      return test::sample_seeds(*scene, settings, method, warm, &reference);
    };
    const test::Sampled usual = sample(clean);
    test::check_method(mode, "no such value", usual, none, &none);
    for (bool everywhere : {false, true}) {
      const test::Sampled hit = sample(with_fireflies(clean, everywhere));
      test::check_method(mode, everywhere ? "one value in every state" : "one value", hit, none,
                         &none);
      if (everywhere) {  // or the values written were never read
        EXPECT_NE(hit.means, usual.means);
      }
    }
  }
}

TEST(TableFirefly, IsForgottenInAChainOfJobs) {
  const test::FailureMode mode("firefly-in-a-table");
  const auto scene = test::prepare(test::room(/*shaded=*/true));
  RenderSettings settings = test::small_settings("huang", kFireflySide, 256);
  settings.learning_samples = 64;
  settings.huang.grid = 8;
  const TableFile clean = *test::learned_table(*scene, settings, "huang", 256);
  const float usual = test::largest_value(clean);
  TableFile table = with_fireflies(clean, /*everywhere=*/false);
  int jobs = 0;
  float largest = kFirefly;
  for (; jobs < 40 && largest > 2 * usual; ++jobs) {
    settings.seed = 600 + static_cast<uint64_t>(jobs);
    const test::Rendered r = test::render(*scene, settings, table);
    EXPECT_EQ(r.job.stats.dropped_samples, 0u);
    table = *r.job.table;
    EXPECT_LE(test::largest_value(table), largest);  // it spreads, but never grows
    largest = test::largest_value(table);
  }
  EXPECT_LE(largest, 2 * usual) << "after " << jobs << " jobs";
  mode.says("huang",
            formatted("no value is over twice the usual largest after %d jobs of %d learning "
                      "samples a pixel",
                      jobs, settings.learning_samples));
}

// The largest value that a file may hold must not become infinite, or the next job refuses it.
TEST(TableFirefly, TheLargestFloatDoesNotOverflow) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = test::small_settings("huang", kFireflySide, 32);
  settings.huang.gamma = 1;
  settings.huang.alpha = 0.02f;
  TableFile table = *test::learned_table(*scene, settings, "huang");
  std::vector<test::HuangState> states = test::huang_states(table);
  for (test::HuangState& state : states) state.q.fill(std::numeric_limits<float>::max());
  test::set_huang_states(table, states);
  for (int job = 0; job < 3; ++job) {
    const test::Rendered r = test::render(*scene, settings, through_bytes(table));
    EXPECT_EQ(r.job.stats.dropped_samples, 0u);
    table = *r.job.table;
  }
}

}  // namespace
}  // namespace qray
