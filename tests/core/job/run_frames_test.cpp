// Jobs of many frames: one table, the same bits for any thread count and after any cut.
#include "core/job/run_frames.h"

#include <gtest/gtest.h>

#include <map>

#include "core/job/load_and_prepare.h"
#include "tests/core/import/gltf_text.h"
#include "tests/support/render.h"
#include "tests/support/sanitized.h"

namespace qray {
namespace {

// Keeps frames in memory.
class Kept final : public FrameKeeper {
 public:
  RenderObserver& begin_turn(int frame, std::shared_ptr<Film> film) override {
    turns.push_back(frame);
    film_ = std::move(film);
    return nobody_;
  }
  Status end_turn(int frame, const FrameProgress& progress, const Film& film,
                  const JobResult& result) override {
    EXPECT_EQ(&film, film_.get());
    progresses[frame] = progress;
    pictures[frame] = result.recovered ? *result.recovered : film.develop();
    metadata[frame] = result.metadata;
    return {};
  }
  Status save(int frame, int turn, const WriteState& write) override {
    Bytes& bytes = states[{frame, turn % 2}];
    bytes.clear();
    SnapshotWriter out([&](std::span<const uint8_t> part) {
      bytes.insert(bytes.end(), part.begin(), part.end());
    });
    write(out);
    return {};
  }
  Status load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) override {
    SnapshotReader in(states[{frame, turn % 2}]);
    return read(in) ? Status() : Status(Error{ErrorCode::kCorrupt, "another turn's", ""});
  }

  std::vector<int> turns;
  std::map<int, Image> pictures;
  std::map<int, FrameProgress> progresses;
  std::map<int, ImageMetadata> metadata;
  std::map<std::pair<int, int>, Bytes> states;

 private:
  std::shared_ptr<Film> film_;
  RenderObserver nobody_;
};

// Writes the job's state, and ends it at every `tiles`-th question if that is over 0.
class Keeper final : public Checkpointer {
 public:
  explicit Keeper(int tiles = 0) : tiles_(tiles) {}
  bool due() override { return tiles_ > 0 && ++asked_ > tiles_; }
  bool save(const std::function<void(SnapshotWriter&)>& write) override {
    bytes.clear();
    SnapshotWriter out([this](std::span<const uint8_t> part) {
      bytes.insert(bytes.end(), part.begin(), part.end());
    });
    write(out);
    return tiles_ == 0 || asked_ <= tiles_;
  }
  Bytes bytes;

 private:
  const int tiles_;
  int asked_ = 0;
};

JobRequest turntable(int count, int samples) {
  JobRequest request;
  request.set(field::kTurntable, count);
  request.set(field::kDegrees, 20.0);
  request.set(field::kSamples, samples);
  return request;
}

Result<JobResult> run(const PreparedScene& scene, const JobRequest& request,
                      const RenderSettings& settings, Kept& kept, int threads = 2,
                      const Checkpoints& checkpoints = {}, const Recovery* recovery = nullptr,
                      const FramesJob::SceneAt& scene_at = {}) {
  const std::vector<JobFrame> frames = frames_of(request, scene.scene).value();
  TaskPool pool(threads);
  StartingGuide start{make_guide(settings.method, scene.guide_setup(settings)).value(), {}};
  return run_frames(scene, {request, settings, frames, scene_at}, std::move(start), kept, pool, {},
                    SteadyClock(), recovery, checkpoints);
}

void expect_same(const Kept& a, const Kept& b) {
  ASSERT_EQ(a.pictures.size(), b.pictures.size());
  for (const auto& [frame, image] : a.pictures)
    EXPECT_TRUE(test::same_bits(image, b.pictures.at(frame))) << frame;
}

class RunFrames : public testing::TestWithParam<const char*> {
 protected:
  const std::shared_ptr<const PreparedScene> scene = test::included_scene("ajar-door");
  RenderSettings settings = test::small_settings(GetParam(), 80, 20);
};

TEST_P(RunFrames, EachHasItsTurnAndAllThatIsAsked) {
  Kept kept;
  const Result<JobResult> job = run(*scene, turntable(3, 20), settings, kept);
  ASSERT_TRUE(job.ok()) << job.error().text();
  EXPECT_EQ(kept.turns, (std::vector<int>{0, 2, 1}));
  uint64_t paths = 0;
  for (const auto& [frame, progress] : kept.progresses) {
    EXPECT_EQ(progress.samples, 20u);
    paths += progress.paths;
    EXPECT_EQ(kept.metadata[frame]["frame"], std::to_string(frame));
  }
  EXPECT_EQ(job.value().stats.frames, 3);
  EXPECT_EQ(job.value().stats.paths, paths);
  EXPECT_EQ(job.value().stats.samples_per_pixel, 20u);
  EXPECT_EQ(job.value().table.has_value(), std::string(GetParam()) != "none");
  EXPECT_FALSE(test::same_bits(kept.pictures[0], kept.pictures[1]));
}

TEST_P(RunFrames, ThreadsChangeNoBit) {
  Kept one, three;
  ASSERT_TRUE(run(*scene, turntable(3, 20), settings, one, 1).ok());
  ASSERT_TRUE(run(*scene, turntable(3, 20), settings, three, 3).ok());
  expect_same(one, three);
}

TEST_P(RunFrames, CutOffAndGoneOnTheyEndWithTheSameBits) {
  const JobRequest request = turntable(3, 20);
  Kept whole;
  const JobResult expected = run(*scene, request, settings, whole).value();
  Kept cut;
  Bytes state;
  int cuts = 0;
  for (;; ++cuts) {
    ASSERT_LT(cuts, 200);
    Keeper keeper(3 + cuts * 5 % 11);
    SnapshotReader reader(state);
    const Result<JobResult> job = run(*scene, request, settings, cut, 1 + cuts % 3,
                                      {&keeper, state.empty() ? nullptr : &reader});
    if (job.ok()) {
      EXPECT_EQ(job.value().stats.rays, expected.stats.rays);
      EXPECT_EQ(job.value().metadata.at("table_out"), expected.metadata.at("table_out"));
      break;
    }
    ASSERT_EQ(job.error().code, ErrorCode::kCanceled) << job.error().text();
    state = keeper.bytes;
  }
  EXPECT_GT(cuts, 5);
  expect_same(cut, whole);
}

// A state that lags behind what frames have become since, as after the end of a process.
TEST_P(RunFrames, GoneOnFromAnOlderStateTheyEndWithTheSameBits) {
  const JobRequest request = turntable(3, 40);
  Kept whole;
  ASSERT_TRUE(run(*scene, request, settings, whole).ok());
  for (const int tiles : {10, 40, 90}) {
    Kept cut;
    Keeper first(tiles);
    ASSERT_FALSE(run(*scene, request, settings, cut, 2, {&first, nullptr}).ok());
    const Bytes old = first.bytes;
    // It goes on for some tiles, none of which is in the state.
    Keeper second(14);
    SnapshotReader reader(old);
    ASSERT_FALSE(run(*scene, request, settings, cut, 2, {&second, &reader}).ok());
    SnapshotReader again(old);
    Keeper last;
    ASSERT_TRUE(run(*scene, request, settings, cut, 2, {&last, &again}).ok());
    expect_same(cut, whole);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, RunFrames, testing::Values("none", "adaptive"),
                         [](const auto& method) { return std::string(method.param); });

TEST(RunFramesJob, OneFrameHasTheBitsOfAJobWithoutFrames) {
  const auto scene = test::included_scene("ajar-door");
  RenderSettings settings = test::small_settings("adaptive", 80, 32);
  Kept kept;
  ASSERT_TRUE(run(*scene, turntable(1, 32), settings, kept).ok());
  settings.camera = scene->scene.camera;
  EXPECT_TRUE(test::same_bits(kept.pictures[0], test::render(*scene, settings).image));
}

TEST(RunFramesJob, MoreIsGivenToAllFrames) {
  const auto scene = test::included_scene("ajar-door");
  RenderSettings settings = test::small_settings("adaptive", 80, 12);
  Kept kept;
  Keeper keeper;
  ASSERT_TRUE(run(*scene, turntable(3, 12), settings, kept, 2, {&keeper, nullptr}).ok());
  for (const int samples : {20, 70}) {
    settings.samples = samples;
    const Bytes state = keeper.bytes;
    SnapshotReader reader(state);
    const Result<JobResult> more =
        run(*scene, turntable(3, samples), settings, kept, 2, {&keeper, &reader});
    ASSERT_TRUE(more.ok()) << more.error().text();
    for (const auto& [frame, progress] : kept.progresses)
      EXPECT_EQ(progress.samples, static_cast<uint64_t>(samples)) << frame;
  }
}

TEST(RunFramesJob, NoiseGivesEachFrameWhatItNeeds) {
  const auto scene = test::included_scene("cornell-box");
  RenderSettings settings = test::small_settings("none", 64, 0);
  settings.samples = 4096;
  settings.noise = 0.04;
  JobRequest request;
  CameraRequest wall;  // what is in the middle alone
  wall.vertical_fov_deg = 8;
  request.set(field::kCameras, Cameras{{"", {}}, {"", wall}});
  Kept kept;
  ASSERT_TRUE(run(*scene, request, settings, kept).ok());
  for (const auto& [frame, progress] : kept.progresses) {
    EXPECT_GT(progress.noise, 0) << frame;
    EXPECT_LE(progress.noise, 0.04) << frame;
    EXPECT_LT(progress.samples, 4096u) << frame;
  }
  EXPECT_NE(kept.progresses[0].samples, kept.progresses[1].samples);
}

// A lamp that passes over a floor, as a file moves it.
class MovingScene : public testing::TestWithParam<const char*> {
 protected:
  MovingScene() {
    test::GltfText text = test::gltf_triangle();
    text.json["materials"].push_back({{"emissiveFactor", {1, 1, 1}}});
    text.json["meshes"].push_back(text.json["meshes"][0]);
    text.primitive(1)["material"] = 1;
    text.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
    text.json["nodes"][0]["scale"] = {4, 4, 1};
    text.json["nodes"].push_back(
        {{"mesh", 1}, {"rotation", {0, 1, 0, 0}}, {"translation", {1, 1, 1}}});
    text.json["nodes"].push_back({{"camera", 0}, {"translation", {1, 1, 4}}});
    text.json["scenes"][0]["nodes"] = {0, 1, 2};
    text.animate(1, "translation", {0, 2}, {1, 1, 1, 3, 1, 2}, "VEC3");
    path = folder.write("a.gltf", text.gltf());
    request.set(field::kAnimation, 1.0);
    request.set(field::kSeeds, std::string("one"));
  }
  std::shared_ptr<const PreparedScene> at(std::optional<double> seconds) const {
    return load_and_prepare_scene(path, 1, {{}, false, {}, seconds}).value();
  }

  const test::SceneFolder folder;
  std::filesystem::path path;
  JobRequest request;
  RenderSettings settings = test::small_settings(GetParam(), 48, 24);
  const FramesJob::SceneAt scene_at = [this](double seconds) { return at(seconds); };
};

TEST_P(MovingScene, EachFrameShowsItAsItIsThen) {
  const auto rest = at({});
  Kept kept;
  ASSERT_TRUE(run(*rest, request, settings, kept, 2, {}, nullptr, scene_at).ok());
  ASSERT_EQ(kept.pictures.size(), 3u);
  settings.camera = rest->scene.camera;
  for (const auto& [frame, picture] : kept.pictures) {
    const Image alone = test::render(*at(frame), settings).image;
    if (std::string(GetParam()) == "none") {
      EXPECT_TRUE(test::same_bits(picture, alone)) << frame;
    } else {  // with what the frames before it taught
      EXPECT_NEAR(test::mean_luminance(picture), test::mean_luminance(alone), 0.1f) << frame;
    }
    EXPECT_EQ(kept.metadata.at(frame).at("seconds_of_animation"),
              std::to_string(static_cast<double>(frame)));
  }
  EXPECT_FALSE(test::same_bits(kept.pictures[0], kept.pictures[1]));
  EXPECT_EQ(kept.turns, (std::vector<int>{0, 1, 2})) << "in that of time";
}

TEST_P(MovingScene, CutOffAndGoneOnItEndsWithTheSameBits) {
  const auto rest = at({});
  Kept whole, cut;
  ASSERT_TRUE(run(*rest, request, settings, whole, 2, {}, nullptr, scene_at).ok());
  Bytes state;
  for (int cuts = 0;; ++cuts) {
    ASSERT_LT(cuts, 200);
    Keeper keeper(2 + cuts % 3);
    SnapshotReader reader(state);
    const Result<JobResult> job =
        run(*rest, request, settings, cut, 1 + cuts % 2,
            {&keeper, state.empty() ? nullptr : &reader}, nullptr, scene_at);
    if (job.ok()) break;
    ASSERT_EQ(job.error().code, ErrorCode::kCanceled) << job.error().text();
    state = keeper.bytes;
  }
  expect_same(cut, whole);
}

INSTANTIATE_TEST_SUITE_P(Methods, MovingScene, testing::Values("none", "adaptive"),
                         [](const auto& method) { return std::string(method.param); });

}  // namespace
}  // namespace qray
