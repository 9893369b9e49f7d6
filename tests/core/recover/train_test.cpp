#include "core/recover/train.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kTrainSide = 64;  // pixels

// Stripes of albedo under a smooth light, seen through noise.
TrainingView stripes(uint64_t seed) {
  test::Random random(seed);
  TrainingView view{{Image(kTrainSide, kTrainSide, kFeatures), Image(kTrainSide, kTrainSide, 3),
                     Image(kTrainSide, kTrainSide, 1), Image(kTrainSide, kTrainSide, 1),
                     Image(kTrainSide, kTrainSide, 3)},
                    Image(kTrainSide, kTrainSide, 3)};
  const float tilt = random.next();
  for (int y = 0; y < kTrainSide; ++y)
    for (int x = 0; x < kTrainSide; ++x) {
      const float albedo = (x / 5 + y / 7) % 2 ? 0.8f : 0.2f;
      const float light = 0.5f + tilt * static_cast<float>(x) / kTrainSide +
                          0.5f * static_cast<float>(y) / kTrainSide;
      for (int k = 0; k < 3; ++k) view.input.features.at(x, y, k) = albedo;
      for (int k = 0; k < 3; ++k)  // says nothing of the light, which must be learned
        view.input.features.at(x, y, kFeatureNormal + k) = random.next();
      view.input.features.at(x, y, kFeatureDepth) = 1;
      view.input.noise.at(x, y, 0) = 0.5f;
      for (int c = 0; c < 3; ++c) {
        view.target.at(x, y, c) = albedo * light;
        view.input.colour.at(x, y, c) = albedo * light * 2 * random.next();
      }
    }
  return view;
}

Trained trained_for(int threads, int steps) {
  std::vector<TrainingView> views;
  for (uint64_t seed = 1; seed <= 6; ++seed) views.push_back(stripes(seed));
  TaskPool pool(threads);
  Result<Trained> trained = train(untrained_network(1), views, 2, {.steps = steps}, pool, {},
                                  [](const TrainProgress&) {});
  EXPECT_TRUE(trained.ok());
  return std::move(trained).value();
}

TEST(Train, LowersTheErrorOfViewsItHasNotSeen) {
  const TrainingView unseen = stripes(77);
  const double before = cleaning_error(untrained_network(1), unseen);
  const Trained trained = trained_for(2, 60);
  EXPECT_EQ(trained.held_out.size(), 2u);
  EXPECT_LT(cleaning_error(trained.network, unseen), 0.6 * before);
}

TEST(Train, AnyNumberOfThreadsMakesTheSameNetwork) {
  EXPECT_EQ(trained_for(1, 4).network.values, trained_for(3, 4).network.values);
}

TEST(Train, AtEachLookItTellsWhatItWouldReturn) {
  std::vector<TrainingView> views{stripes(1), stripes(2)};
  TaskPool pool(2);
  std::vector<std::vector<float>> told;
  const Result<Trained> trained =
      train(untrained_network(1), views, 1, {.steps = 3}, pool, {},
            [&](const TrainProgress& p) { told.emplace_back(p.values.begin(), p.values.end()); });
  ASSERT_TRUE(trained.ok());
  ASSERT_EQ(told.size(), 3u);
  EXPECT_TRUE(told[1].empty());
  EXPECT_EQ(told[2], trained.value().network.values);
}

TEST(Train, StopsWhenAsked) {
  std::vector<TrainingView> views{stripes(1), stripes(2)};
  TaskPool pool(2);
  std::stop_source stop;
  int steps = 0;
  const Result<Trained> trained = train(untrained_network(1), views, 1, {.steps = 1000}, pool,
                                        stop.get_token(), [&](const TrainProgress& p) {
                                          steps = p.step;
                                          if (p.step == 3) stop.request_stop();
                                        });
  ASSERT_FALSE(trained.ok());
  EXPECT_EQ(trained.error().code, ErrorCode::kCanceled);
  EXPECT_EQ(steps, 3);
}

}  // namespace
}  // namespace qray
