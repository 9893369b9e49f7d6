#include "core/image/exposure.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

Image grey(std::initializer_list<float> values) {
  Image image(static_cast<int>(values.size()), 1, 3);
  int x = 0;
  for (const float v : values) image.set_rgb(x++, 0, Rgb{v});
  return image;
}

TEST(Exposure, AutoBringsTheLogAverageToMiddleGrey) {
  EXPECT_NEAR(auto_exposure(grey({0.18f})), 0, 1e-5);
  EXPECT_NEAR(auto_exposure(grey({0.18f * 1024})), -10, 1e-4);
  EXPECT_NEAR(auto_exposure(grey({0.09f, 0.36f})), 0, 1e-5);
  Image bright = grey({2049, 300, 5000});
  expose(bright, auto_exposure(bright));
  EXPECT_NEAR(auto_exposure(bright), 0, 1e-4);
}

TEST(Exposure, AutoPassesOverWhatIsBlackOrNoNumber) {
  EXPECT_NEAR(auto_exposure(grey({0, 0.18f, 0, NAN, INFINITY})), 0, 1e-5);
  EXPECT_EQ(auto_exposure(grey({0, 0})), 0);
  EXPECT_EQ(auto_exposure(grey({1e-30f})), kMaxExposure);
}

TEST(Exposure, AStopIsTwiceTheLight) {
  Image image = grey({0.5f, 3});
  expose(image, -2);
  EXPECT_EQ(image.rgb(0, 0), Rgb{0.125f});
  EXPECT_EQ(image.rgb(1, 0), Rgb{0.75f});
}

}  // namespace
}  // namespace qray
