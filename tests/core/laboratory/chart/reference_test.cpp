#include "core/laboratory/chart/reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/laboratory/chart/chart_run.h"
#include "tests/support/scratch.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

Image uniform(int side, Rgb c) {
  Image image(side, side, 3);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) image.set_rgb(x, y, c);
  return image;
}

TEST(HalvesError, ByHand) {
  // Mean 2, each half .2 away: .04 / 4.01. Luminances 2.2 and 1.8, one pixel.
  const HalvesError e = halves_error(uniform(1, Rgb{2.2f}), uniform(1, Rgb{1.8f})).value();
  EXPECT_NEAR(e.relmse, 0.04 / 4.01, 1e-7);
  EXPECT_NEAR(e.mean_standard_error, 0.2 / 2, 1e-6);
  EXPECT_EQ(halves_error(uniform(3, Rgb{0.0f}), uniform(3, Rgb{0.0f})).value().relmse, 0);
}

TEST(HalvesError, IsWhatTheMeanIsOffTheTruth) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.1f);
  const Image truth = uniform(64, Rgb{1.0f});
  double estimated = 0, actual = 0, mean_squares = 0, mean_estimated = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Image a = truth, b = truth, middle = truth;
    for (size_t i = 0; i < truth.data().size(); i += 3) {
      const float na = noise(random), nb = noise(random);  // gray, pixels independent
      for (size_t c = i; c < i + 3; ++c) {
        a.data()[c] += na;
        b.data()[c] += nb;
        middle.data()[c] += (na + nb) / 2;
      }
    }
    const HalvesError e = halves_error(a, b).value();
    const ImageDifference d = image_difference(middle, truth).value();
    estimated += e.relmse / 100;
    actual += d.relmse / 100;
    mean_estimated += e.mean_standard_error / 100;
    mean_squares += (d.mean_ratio - 1) * (d.mean_ratio - 1) / 100;
  }
  EXPECT_NEAR(actual, 0.01 / 2 / 1.01, 4.4e-5);  // 4 standard errors
  EXPECT_NEAR(estimated / actual, 1, 0.02);
  EXPECT_NEAR(mean_estimated, 0.1 / std::sqrt(2) / 64, 2e-5);
  EXPECT_NEAR(std::sqrt(mean_squares) / mean_estimated, 1, 0.25);
}

class ReferenceCache : public ::testing::Test {
 protected:
  ReferenceCache() {
    settings_.method = "none";
    settings_.width = 24;
    settings_.height = 16;
    settings_.seconds = 0.05;
  }
  std::filesystem::path path() const {
    return reference_path(scratch_ / "cache", "My room", *scene_, settings_);
  }
  Result<Reference> make() {
    RenderObserver observer;
    return make_reference(path(), *scene_, settings_, pool_, observer, {}, SteadyClock());
  }
  test::ScratchFolder scratch_;
  std::shared_ptr<const PreparedScene> scene_ = test::prepare(test::room());
  RenderSettings settings_;
  TaskPool pool_{1};
};

TEST_F(ReferenceCache, KeepsWhatItMade) {
  EXPECT_FALSE(find_reference(path(), 0).value());
  const Reference made = make().value();
  const Reference found = find_reference(path(), 0.05).value().value();
  EXPECT_TRUE(std::equal(made.picture.data().begin(), made.picture.data().end(),
                         found.picture.data().begin(), found.picture.data().end()));
  const ChartReference &a = made.about, &b = found.about;
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(b.scene_hash, scene_->hash.whole().hex());
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(b.height, 16);
  EXPECT_EQ(b.method, "none");
  EXPECT_EQ(a.samples_per_pixel, b.samples_per_pixel);
  EXPECT_GE(b.samples_per_pixel, 2u);
  EXPECT_EQ(a.seconds, b.seconds);
  EXPECT_EQ(a.path, b.path);
  EXPECT_EQ(a.floor_relmse, b.floor_relmse);
  EXPECT_EQ(a.floor_trimmed, b.floor_trimmed);
  EXPECT_EQ(a.mean_standard_error, b.mean_standard_error);
  EXPECT_GT(b.floor_relmse, b.floor_trimmed * 0.99);
  EXPECT_GT(b.mean_standard_error, 0);

  EXPECT_TRUE(find_reference(path(), 0.01).value()) << "a longer one will do";
  EXPECT_FALSE(find_reference(path(), 0.06).value()) << "a shorter one will not";
}

TEST_F(ReferenceCache, NamesWhatItDependsOn) {
  const std::filesystem::path first = path();
  EXPECT_EQ(first.parent_path(), scratch_ / "cache");
  EXPECT_TRUE(first.filename().string().starts_with("my-room-"));
  settings_.seconds = 9;
  settings_.seed = 9;
  EXPECT_EQ(path(), first);
  const RenderSettings before = settings_;
  settings_.width = 25;
  EXPECT_NE(path(), first);
  settings_ = before;
  settings_.max_depth = 3;
  EXPECT_NE(path(), first);
  settings_ = before;
  settings_.method = "huang";
  EXPECT_NE(path(), first);
  settings_ = before;
  Scene moved = test::room();
  moved.camera.position.x += 0.1f;
  scene_ = test::prepare(moved);
  EXPECT_NE(path(), first);
  Scene lit = test::room();
  lit.materials[2].emission.value.g *= 2;
  scene_ = test::prepare(lit);
  EXPECT_NE(path(), first);
}

TEST_F(ReferenceCache, RefusesOtherPictures) {
  std::filesystem::create_directories(path().parent_path());
  ASSERT_TRUE(write_image(path(), uniform(4, Rgb{0.5f}), {{"scene_hash", "x"}}).ok());
  const auto found = find_reference(path(), 0);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(found.error().where, path().string());
}

}  // namespace
}  // namespace qray
