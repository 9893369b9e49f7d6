// A job that is cut off again and again, and goes on from the bytes that it left, ends with the
// same bits as one that was let alone.
#include <gtest/gtest.h>

#include "core/job/run_job.h"
#include "core/recover/included_networks.h"
#include "tests/support/render.h"
#include "tests/support/sanitized.h"
#include "tests/support/tile_clock.h"

namespace qray {
namespace {

// Ends the render at every `tiles`-th tile, between two; keeps its state.
class CutOff final : public Checkpointer {
 public:
  explicit CutOff(int tiles) : tiles_(tiles) {}
  bool due() override { return ++asked_ > tiles_; }
  bool save(const std::function<void(SnapshotWriter&)>& write) override {
    bytes.clear();
    SnapshotWriter out([this](std::span<const uint8_t> part) {
      bytes.insert(bytes.end(), part.begin(), part.end());
    });
    write(out);
    return false;
  }
  Bytes bytes;

 private:
  const int tiles_;
  int asked_ = 0;
};

// Keeps the state of the job that has ended.
class AtTheEnd final : public Checkpointer {
 public:
  bool due() override { return false; }
  bool save(const std::function<void(SnapshotWriter&)>& write) override {
    SnapshotWriter out([this](std::span<const uint8_t> part) {
      bytes.insert(bytes.end(), part.begin(), part.end());
    });
    write(out);
    return true;
  }
  Bytes bytes;
};

std::vector<float> values_of(const Image& image) {
  return {image.data().begin(), image.data().end()};
}

class Quiet final : public RenderObserver {};

Result<JobResult> run(const PreparedScene& scene, const RenderSettings& settings,
                      std::optional<TableFile> table, Film& film, int threads,
                      const Recovery* recovery, const Checkpoints& checkpoints) {
  TaskPool pool(threads);
  Quiet quiet;
  return run_job(scene, settings, std::move(table), film, pool, quiet, {}, SteadyClock(), recovery,
                 checkpoints);
}

struct Case {
  std::string name, method;
  Pixels pixels = Pixels::kAll;
  bool warm = false, recovers = false;
  int samples = test::kSanitized ? 8 : 12;
};
void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

class Checkpoint : public testing::TestWithParam<Case> {};

TEST_P(Checkpoint, CutOffAndGoneOnItEndsWithTheSameBits) {
  const Case& c = GetParam();
  const auto scene = test::included_scene("ajar-door");
  // 12 tiles a pass, the last ones narrow; of the small one 6.
  RenderSettings settings = test::small_settings(c.method, 200, c.samples);
  settings.height = 130;
  if (test::kSanitized) {
    settings.width = 130;
    settings.height = 66;
  }
  settings.pixels = c.pixels;
  std::optional<TableFile> table;
  if (c.warm) {
    Film film(settings.width, settings.height);
    table = run(*scene, settings, {}, film, 2, nullptr, {}).value().table;
    settings.seed = 2;
  }
  std::optional<Recovery> recovery;
  if (c.recovers) recovery = Recovery{"default", included_network("default").value()};
  const Recovery* with = recovery ? &*recovery : nullptr;

  Film whole(settings.width, settings.height);
  const JobResult expected = run(*scene, settings, table, whole, 2, with, {}).value();

  Bytes state;
  int cuts = 0;
  for (;;) {
    Film film(settings.width, settings.height);
    // Within passes and, by chance, between them.
    CutOff keeper(test::kSanitized ? 2 + cuts * 5 % 7 : 5 + cuts * 7 % 23);
    SnapshotReader reader(state);
    const Result<JobResult> job = run(*scene, settings, table, film, 1 + cuts % 3, with,
                                      {&keeper, state.empty() ? nullptr : &reader});
    if (!job.ok()) {
      ASSERT_EQ(job.error().code, ErrorCode::kCanceled) << job.error().text();
      state = keeper.bytes;
      ASSERT_LT(++cuts, 100);
      continue;
    }
    EXPECT_EQ(values_of(film.develop()), values_of(whole.develop()));
    const JobResult& result = job.value();
    EXPECT_EQ(result.stats.passes, expected.stats.passes);
    EXPECT_EQ(result.stats.paths, expected.stats.paths);
    EXPECT_EQ(result.stats.rays, expected.stats.rays);
    EXPECT_EQ(result.stats.noise, expected.stats.noise);
    EXPECT_EQ(result.stats.table_bytes, expected.stats.table_bytes);
    EXPECT_EQ(result.stats.guide_passes.size(), expected.stats.guide_passes.size());
    EXPECT_EQ(result.metadata, expected.metadata);  // the tables' ids: hashes of what they hold
    EXPECT_EQ(result.table.has_value(), c.method != "none");
    EXPECT_EQ(result.recovered.has_value(), c.recovers);
    if (result.recovered) {
      EXPECT_EQ(values_of(*result.recovered), values_of(*expected.recovered));
    }
    break;
  }
  EXPECT_GT(cuts, 5);
  if (c.pixels != Pixels::kByNoise) return;
  settings.pixels = Pixels::kQuarter;
  Film alike(settings.width, settings.height);
  ASSERT_TRUE(run(*scene, settings, table, alike, 2, with, {}).ok());
  EXPECT_NE(values_of(alike.develop()), values_of(whole.develop())) << "no counts by noise";
}

INSTANTIATE_TEST_SUITE_P(
    Jobs, Checkpoint,
    testing::Values(Case{"none", "none"}, Case{"adaptive", "adaptive"},
                    Case{"adaptive_warm", "adaptive", Pixels::kAll, true}, Case{"huang", "huang"},
                    Case{"huang_warm", "huang", Pixels::kAll, true},
                    Case{"dahm_keller", "dahm-keller"}, Case{"ppg", "ppg"},
                    Case{.name = "adaptive_pixels",
                         .method = "adaptive",
                         .pixels = Pixels::kByNoise,
                         .samples = 40},
                    Case{"quarter_recovered", "none", Pixels::kQuarter, false, true}),
    [](const auto& info) { return info.param.name; });

// The state of a finished job serves to render more.
TEST(Checkpoint, AFinishedJobGoesOnToMoreSamples) {
  const auto scene = test::included_scene("cornell-box");
  RenderSettings settings = test::small_settings("adaptive", 64, 8);
  AtTheEnd keep;
  Film film(64, 64);
  ASSERT_TRUE(run(*scene, settings, {}, film, 2, nullptr, {&keep, nullptr}).ok());
  const Image before = film.develop();
  ASSERT_FALSE(keep.bytes.empty());

  settings.samples = 20;
  SnapshotReader reader(keep.bytes);
  Film more(64, 64);
  const uint64_t version = film.version();
  const Result<JobResult> job = run(*scene, settings, {}, more, 2, nullptr, {nullptr, &reader});
  ASSERT_TRUE(job.ok()) << job.error().text();
  EXPECT_EQ(job.value().stats.samples_per_pixel, 20u);
  EXPECT_EQ(
      std::vector<int>(job.value().stats.passes.begin(), job.value().stats.passes.begin() + 4),
      (std::vector<int>{1, 1, 1, 1}));
  EXPECT_GT(more.version(), version);  // who followed the first film is told of all tiles anew
  EXPECT_EQ(more.tiles_since(version, 10).tiles.size(), 1u);
  EXPECT_NE(values_of(more.develop()), values_of(before));
}

// It ends within a pass; the rest of that comes first.
TEST(Checkpoint, AJobThatTimeCutShortGoesOnToMoreSamples) {
  const auto scene = test::included_scene("cornell-box");
  for (const char* method : {"none", "adaptive"}) {
    RenderSettings settings = test::small_settings(method, 100, 0);  // four tiles
    settings.seconds = 10.5;
    AtTheEnd keep;
    Film film(100, 100), more(100, 100), let_alone(100, 100);
    TaskPool pool(1);
    test::TileClock clock;
    ASSERT_TRUE(
        run_job(*scene, settings, {}, film, pool, clock, {}, clock, nullptr, {&keep, nullptr})
            .ok());
    settings.seconds = 0;
    settings.samples = 8;
    SnapshotReader reader(keep.bytes);
    const Result<JobResult> job = run(*scene, settings, {}, more, 2, nullptr, {nullptr, &reader});
    ASSERT_TRUE(job.ok()) << job.error().text();
    const RenderStats& stats = job.value().stats;
    EXPECT_EQ(stats.samples_per_pixel, 8u);
    EXPECT_EQ(stats.last_pass_tiles, 0);
    settings.passes = stats.passes;
    settings.learning_samples = static_cast<int>(stats.learning_samples_per_pixel);
    ASSERT_TRUE(run(*scene, settings, {}, let_alone, 2, nullptr, {}).ok());
    EXPECT_EQ(values_of(more.develop()), values_of(let_alone.develop())) << method;
  }
}

TEST(Checkpoint, AStateOfAnotherRenderIsRefused) {
  const auto scene = test::included_scene("cornell-box");
  RenderSettings settings = test::small_settings("adaptive", 64, 4);
  CutOff keeper(1);
  Film film(64, 64);
  ASSERT_FALSE(run(*scene, settings, {}, film, 2, nullptr, {&keeper, nullptr}).ok());
  const Bytes good = keeper.bytes;
  const auto refused = [&](const Bytes& bytes, RenderSettings s) {
    SnapshotReader reader(bytes);
    Film fresh(s.width, s.height);
    const Result<JobResult> job = run(*scene, s, {}, fresh, 1, nullptr, {nullptr, &reader});
    return !job.ok() && job.error().code == ErrorCode::kCorrupt;
  };
  EXPECT_FALSE(refused(good, settings));
  RenderSettings other = settings;
  other.method = "huang";
  EXPECT_TRUE(refused(good, other));
  other = settings;
  other.seed = 7;
  EXPECT_TRUE(refused(good, other));
  other = settings;
  other.width = 32;
  EXPECT_TRUE(refused(good, other));
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_TRUE(refused(longer, settings));
  // Cut off anywhere.
  for (size_t size = 0; size < good.size(); size += 1 + good.size() / 50)
    EXPECT_TRUE(
        refused(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)), settings))
        << size;
}

}  // namespace
}  // namespace qray
