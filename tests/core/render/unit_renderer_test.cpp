// A pass whose units are sampled by several renderers, in any order, by any number of threads and
// some twice, gives the bits of one that was sampled by one.
#include "core/render/unit_renderer.h"

#include <gtest/gtest.h>

#include <random>

#include "core/job/run_job.h"
#include "core/recover/included_networks.h"
#include "tests/support/render.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// Several processes' worth of renderers, of one and of two threads.
class Sharing final : public PassSampler {
 public:
  Sharing(const PreparedScene& scene, const RenderSettings& settings, int processes)
      : settings_(settings) {
    for (int i = 0; i < processes; ++i) {
      pools_.push_back(std::make_unique<TaskPool>(1 + i % 2));
      renderers_.push_back(UnitRenderer::make(scene, settings_, *pools_.back()).value());
    }
  }

  Status sample(Renderer& renderer, const std::function<bool()>& enough,
                const std::stop_token& stop, RenderObserver& observer) override {
    hand_over(renderer);
    const size_t first = renderer.next_unit(), left = renderer.units_left();
    // Parts of the pass, sampled in a random order.
    std::vector<std::pair<size_t, size_t>> parts;  // first, count
    for (size_t at = 0; at < left;) {
      const size_t count = std::min<size_t>(1 + random_() % 3, left - at);
      parts.emplace_back(first + at, count);
      at += count;
    }
    std::map<size_t, Bytes> sampled;
    std::shuffle(parts.begin(), parts.end(), random_);
    for (const auto& [at, count] : parts) {
      const Bytes one = some().sample(at, count, stop).value();
      // Whoever samples it gives the same bytes, measured times left out.
      if (random_() % 4 == 0) {
        const Bytes again = some().sample(at, count, stop).value();
        const auto times = static_cast<std::ptrdiff_t>(UnitRenderer::kTimesBytes);
        EXPECT_TRUE(std::equal(one.begin() + times, one.end(), again.begin() + times, again.end()));
      }
      bytes_ += one.size();
      sampled[at] = one;
    }
    for (const auto& [at, bytes] : sampled) {
      if (enough()) break;
      EXPECT_TRUE(renderer.add_units(bytes, observer));
      EXPECT_FALSE(renderer.in_pass() && renderer.units_left() > 0 &&
                   renderer.add_units(bytes, observer))
          << "units that are there already";
    }
    return {};
  }
  size_t bytes() const { return bytes_; }

 private:
  UnitRenderer& some() { return *renderers_[random_() % renderers_.size()]; }
  void hand_over(const Renderer& renderer) {
    Bytes pass, guide;
    const auto to = [](Bytes& bytes) {
      return SnapshotWriter([&bytes](std::span<const uint8_t> part) {
        bytes.insert(bytes.end(), part.begin(), part.end());
      });
    };
    SnapshotWriter pass_out = to(pass), guide_out = to(guide);
    renderer.save_pass(pass_out);
    if (renderer.needs_guide()) renderer.save_guide(guide_out);
    for (const auto& one : renderers_) {
      SnapshotReader pass_in(pass), guide_in(guide);
      if (renderer.needs_guide()) {
        ASSERT_TRUE(one->set_guide(guide_in));
      }
      ASSERT_TRUE(one->start_pass(pass_in));
    }
  }

  const RenderSettings settings_;
  std::vector<std::unique_ptr<TaskPool>> pools_;
  std::vector<std::unique_ptr<UnitRenderer>> renderers_;
  std::mt19937 random_{7};
  size_t bytes_ = 0;
};

struct InUnits {
  Image image;
  JobResult job;
};

InUnits run(const PreparedScene& scene, const RenderSettings& settings,
            std::optional<TableFile> table, const Recovery* recovery, int processes) {
  Film film(settings.width, settings.height);
  TaskPool pool(2);
  RenderObserver nobody;
  const SteadyClock clock;
  StartingGuide start{load_guide(scene, settings, table).value(), {}};
  if (table) start.table = table->header;
  std::optional<Sharing> sharing;
  if (processes > 0) sharing.emplace(scene, settings, processes);
  JobResult job = run_guided_job(scene, settings, std::move(start), film, pool, nobody, {}, clock,
                                 recovery, {}, sharing ? &*sharing : nullptr)
                      .value();
  if (sharing) {
    EXPECT_GT(sharing->bytes(), 0u);
  }
  return {film.develop(), std::move(job)};
}

struct Case {
  std::string name, method;
  Pixels pixels = Pixels::kAll;
  bool warm = false, recovers = false;
  int samples = test::kSanitized ? 6 : 12;
};
void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

class SharedPasses : public testing::TestWithParam<Case> {};

TEST_P(SharedPasses, HaveTheBitsOfOneProcess) {
  const Case& c = GetParam();
  const auto scene = test::included_scene("ajar-door");
  RenderSettings settings = test::small_settings(c.method, 200, c.samples);
  settings.height = 130;
  settings.pixels = c.pixels;
  std::optional<TableFile> table;
  if (c.warm) {
    table = run(*scene, settings, {}, nullptr, 0).job.table;
    settings.seed = 2;
  }
  std::optional<Recovery> recovery;
  if (c.recovers) recovery = Recovery{"default", included_network("default").value()};
  const Recovery* with = recovery ? &*recovery : nullptr;
  const InUnits alone = run(*scene, settings, table, with, 0);
  const InUnits shared = run(*scene, settings, table, with, 3);
  EXPECT_TRUE(test::same_bits(alone.image, shared.image));
  if (c.pixels == Pixels::kByNoise) {
    settings.pixels = Pixels::kQuarter;
    EXPECT_FALSE(test::same_bits(alone.image, run(*scene, settings, table, with, 0).image));
  }
  EXPECT_EQ(alone.job.stats.rays, shared.job.stats.rays);
  EXPECT_EQ(alone.job.stats.passes, shared.job.stats.passes);
  ASSERT_EQ(alone.job.table.has_value(), shared.job.table.has_value());
  if (alone.job.table) {
    EXPECT_EQ(alone.job.table->header.id, shared.job.table->header.id);
  }
  if (with) {
    EXPECT_TRUE(test::same_bits(*alone.job.recovered, *shared.job.recovered));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedPasses,
    testing::Values(
        Case{"none", "none"}, Case{"adaptive_cold", "adaptive"},
        Case{.name = "adaptive_warm", .method = "adaptive", .warm = true},
        Case{.name = "by_noise", .method = "adaptive", .pixels = Pixels::kByNoise, .samples = 40},
        Case{.name = "quarter_recovered",
             .method = "adaptive",
             .pixels = Pixels::kQuarter,
             .recovers = true}),
    [](const auto& info) { return info.param.name; });

TEST(UnitRenderer, RefusesWhatIsNotOfItsRender) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 64, 4);
  TaskPool pool(1);
  const auto units = UnitRenderer::make(*scene, settings, pool).value();
  RenderSettings other = settings;
  other.seed = 9;
  const std::unique_ptr<Guide> guide = load_guide(*scene, other, std::nullopt).value();
  Film film(other.width, other.height);
  const SteadyClock clock;
  Renderer renderer(*scene, other, guide.get(), film, pool, clock);
  ASSERT_TRUE(renderer.start_pass());
  Bytes pass;
  SnapshotWriter out(
      [&](std::span<const uint8_t> part) { pass.insert(pass.end(), part.begin(), part.end()); });
  renderer.save_pass(out);
  SnapshotReader whole(pass), cut(std::span<const uint8_t>(pass).first(pass.size() / 2));
  EXPECT_FALSE(units->start_pass(whole)) << "another seed";
  EXPECT_FALSE(units->start_pass(cut));
  EXPECT_FALSE(renderer.add_units(pass, *std::make_unique<RenderObserver>()));
}

TEST(UnitRenderer, UnitsThatWereDamagedAreRefused) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 64, 4);
  TaskPool pool(1);
  const auto units = UnitRenderer::make(*scene, settings, pool).value();
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, std::nullopt).value();
  Film film(settings.width, settings.height);
  const SteadyClock clock;
  Renderer renderer(*scene, settings, guide.get(), film, pool, clock);
  RenderObserver nobody;
  ASSERT_TRUE(renderer.start_pass());
  ASSERT_TRUE(renderer.needs_guide());
  Bytes pass, copy;
  SnapshotWriter pass_out(
      [&](std::span<const uint8_t> part) { pass.insert(pass.end(), part.begin(), part.end()); });
  SnapshotWriter copy_out(
      [&](std::span<const uint8_t> part) { copy.insert(copy.end(), part.begin(), part.end()); });
  renderer.save_pass(pass_out);
  renderer.save_guide(copy_out);
  SnapshotReader pass_in(pass), copy_in(copy);
  ASSERT_TRUE(units->set_guide(copy_in));
  ASSERT_TRUE(units->start_pass(pass_in));
  const Bytes whole = units->sample(0, 1, {}).value();
  for (size_t size = 0; size < whole.size(); size += 1 + size / 16)
    EXPECT_FALSE(renderer.add_units(std::span<const uint8_t>(whole).first(size), nobody)) << size;
  EXPECT_FALSE(units->sample(1, 1, {})) << "there is one tile";
  EXPECT_EQ(film.version(), 0u);
  EXPECT_EQ(guide->stats().samples_seen, 0u);
  EXPECT_TRUE(renderer.add_units(whole, nobody));
  EXPECT_GT(guide->stats().samples_seen, 0u);
}

// Else two workers would be told apart by what each sampled before.
TEST(UnitRenderer, ItsBytesDoNotTellOfTheUnitsBefore) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = test::small_settings("none", 72, 4);  // tiles of 64 and of 8 pixels
  TaskPool pool(1);
  Film film(settings.width, settings.height);
  const SteadyClock clock;
  Renderer renderer(*scene, settings, nullptr, film, pool, clock);
  ASSERT_TRUE(renderer.start_pass());
  Bytes pass;
  SnapshotWriter out(
      [&](std::span<const uint8_t> part) { pass.insert(pass.end(), part.begin(), part.end()); });
  renderer.save_pass(out);
  std::vector<Bytes> sampled;
  for (const bool large_first : {false, true}) {
    const auto units = UnitRenderer::make(*scene, settings, pool).value();
    SnapshotReader in(pass);
    ASSERT_TRUE(units->start_pass(in));
    if (large_first) {
      ASSERT_TRUE(units->sample(0, 1, {}));
    }
    Bytes one = units->sample(1, 1, {}).value();
    one.erase(one.begin(), one.begin() + UnitRenderer::kTimesBytes);
    sampled.push_back(std::move(one));
  }
  EXPECT_EQ(sampled[0], sampled[1]);
}

TEST(UnitRenderer, OneProcessRendersWhatLearnsInOrder) {
  const auto scene = test::prepare(test::room());
  TaskPool pool(1);
  for (const char* method : {"huang", "huang-published", "ppg", "dahm-keller"}) {
    const auto made = UnitRenderer::make(*scene, test::small_settings(method, 64, 4), pool);
    ASSERT_FALSE(made.ok()) << method;
    EXPECT_EQ(made.error().code, ErrorCode::kInvalid);
  }
}

}  // namespace
}  // namespace qray
