#include "core/recover/open_image_denoise.h"

#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "core/recover/network.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kSide = 96;  // pixels

TEST(OpenImageDenoise, MakesANoisyPictureSmoothAndKeepsItsLight) {
  const Result<std::shared_ptr<const OpenImageDenoise>> peer = OpenImageDenoise::open();
  if (!peer.ok()) {
    EXPECT_EQ(peer.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(peer.error().where, "libOpenImageDenoise.so.2");
    GTEST_SKIP() << "needs the library of Open Image Denoise 2 where the loader finds it: "
                 << peer.error().text();
  }
  test::Random random(1);
  Image features(kSide, kSide, kFeatures), noisy(kSide, kSide, 3), truth = noisy;
  double light = 0, got = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const float albedo = (x / 16 + y / 16) % 2 ? 0.7f : 0.3f;
      features.at(x, y, kFeatureNormal) = 1;
      for (int c = 0; c < 3; ++c) {
        features.at(x, y, c) = albedo;
        truth.at(x, y, c) = albedo * 1.5f;
        noisy.at(x, y, c) = albedo * 1.5f * 2 * random.next();
        light += static_cast<double>(truth.at(x, y, c));
      }
    }
  const Result<Image> picture = peer.value()->denoise(features, noisy, 2);
  ASSERT_TRUE(picture.ok()) << picture.error().text();
  EXPECT_LT(relmse(picture.value(), truth), 0.1 * relmse(noisy, truth));
  for (const float v : picture.value().data()) got += static_cast<double>(v);
  EXPECT_NEAR(got / light, 1, 0.03);
  // Its own pictures stay as they were.
  EXPECT_EQ(features.at(0, 0, 0), 0.3f);
}

}  // namespace
}  // namespace qray
