#include "core/recover/loss.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace qray {
namespace {

Image random_image(test::Random& random, int width, int height) {
  Image image(width, height, 3);
  for (float& v : image.data()) v = 2 * random.next();
  return image;
}

TEST(Loss, OfLogarithmsHasTheGradientOfFiniteDifferences) {
  test::Random random(5);
  Image result = random_image(random, 7, 5);
  const Image albedo = random_image(random, 7, 5), target = random_image(random, 7, 5);
  std::vector<float> gradient, unused;
  log_loss(result, albedo, target, gradient);
  ASSERT_EQ(gradient.size(), result.data().size());
  for (size_t i = 0; i < gradient.size(); ++i) {
    constexpr float kStep = 1e-3f;
    const float kept = result.data()[i];
    result.data()[i] = kept + kStep;
    const double more = log_loss(result, albedo, target, unused);
    result.data()[i] = kept - kStep;
    const double less = log_loss(result, albedo, target, unused);
    result.data()[i] = kept;
    EXPECT_NEAR(gradient[i], (more - less) / (2 * static_cast<double>(kStep)),
                1e-4 + 0.005 * std::abs(static_cast<double>(gradient[i])))
        << i;
  }
}

TEST(Loss, OfLogarithmsIsNoneWhereAllIsRight) {
  test::Random random(6);
  const Image result = random_image(random, 8, 8);
  Image albedo(8, 8, 3), target = result;
  for (float& v : albedo.data()) v = 0.5f;
  for (float& v : target.data()) v *= 0.5f;
  std::vector<float> gradient;
  EXPECT_NEAR(log_loss(result, albedo, target, gradient), 0, 1e-6);
}

TEST(Loss, OfLogarithmsBlotchesCountMoreThanAnEvenError) {
  Image albedo(8, 8, 3), target(8, 8, 3), even(8, 8, 3), blotches(8, 8, 3);
  std::vector<float> gradient;
  for (int i = 0; i < 64; ++i)
    for (int c = 0; c < 3; ++c) {
      albedo.at(i % 8, i / 8, c) = 1;
      target.at(i % 8, i / 8, c) = 0.5f;
      even.at(i % 8, i / 8, c) = 0.6f;
      blotches.at(i % 8, i / 8, c) = (i % 8 + i / 8) % 2 ? 0.6f : 0.4f;
    }
  EXPECT_GT(log_loss(blotches, albedo, target, gradient),
            1.5 * log_loss(even, albedo, target, gradient));
}

}  // namespace
}  // namespace qray
