#include "core/guide/directions26.h"

#include <gtest/gtest.h>

#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

Vec2 random_point(uint64_t i) {
  const uint64_t h = mix64(i);
  return {to_unit_float(static_cast<uint32_t>(h)), to_unit_float(static_cast<uint32_t>(h >> 32))};
}

TEST(Directions26, NearestIsTheLargestCosine) {
  for (uint64_t i = 0; i < 100'000; ++i) {
    const Vec3 d = square_to_uniform_sphere(random_point(i));
    int best = 0;
    for (int a = 1; a < kDirections26; ++a)
      if (dot(d, directions26()[static_cast<size_t>(a)]) >
          dot(d, directions26()[static_cast<size_t>(best)]))
        best = a;
    const int found = nearest_direction26(d);
    const float lost = dot(d, directions26()[static_cast<size_t>(best)]) -
                       dot(d, directions26()[static_cast<size_t>(found)]);
    EXPECT_LT(lost, 1e-6f) << d.x << " " << d.y << " " << d.z;
  }
  for (int a = 0; a < kDirections26; ++a)
    EXPECT_EQ(nearest_direction26(directions26()[static_cast<size_t>(a)]), a);
}

TEST(Directions26, SharesMatchCountedHemispheres) {
  constexpr int kSamples = 200'000;
  for (uint64_t k = 0; k < 6; ++k) {
    const Vec3 n = k == 0 ? Vec3{0, 0, 1} : square_to_uniform_sphere(random_point(k + 99));
    const Frame frame(n);
    const auto shares = hemisphere_shares26(n);
    std::array<double, kDirections26> counted{};
    for (uint64_t i = 0; i < kSamples; ++i) {
      const Vec3 d = frame.to_world(square_to_uniform_hemisphere(random_point(i * 8 + k)));
      counted[static_cast<size_t>(nearest_direction26(d))] += 1.0 / kSamples;
    }
    double sum = 0;
    for (size_t a = 0; a < shares.size(); ++a) {
      sum += shares[a];
      const double sigma = std::sqrt(shares[a] * (1 - shares[a]) / kSamples) + 1e-9;
      EXPECT_LT(std::abs(counted[a] - shares[a]), 5 * sigma) << "normal " << k << " action " << a;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST(Directions26, SharesAreFarFromEqual) {
  // The design's measured range for these normals: .002 to .092, never 1/26 each.
  const float root = std::sqrt(14.0f);
  const auto shares = hemisphere_shares26({1 / root, 2 / root, 3 / root});
  float least = 1, most = 0;
  for (float s : shares) {
    if (s > 0) least = std::min(least, s);
    most = std::max(most, s);
  }
  EXPECT_LT(least, 0.01f);
  EXPECT_GT(most, 0.08f);
}

}  // namespace
}  // namespace qray
