#include "core/image/rgb9e5.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random.h"

namespace qray {
namespace {

TEST(Rgb9e5, PublishedValues) {
  EXPECT_EQ(pack_rgb9e5({0, 0, 0}), 0u);
  // 1 = 256 / 2^9 * 2^(16-15): mantissa 256, exponent 16.
  EXPECT_EQ(pack_rgb9e5({1, 1, 1}), 256u | 256u << 9 | 256u << 18 | 16u << 27);
  EXPECT_EQ(pack_rgb9e5({1, 0.5f, 0.25f}), 256u | 128u << 9 | 64u << 18 | 16u << 27);
  // The largest: 511/512 * 2^16 = 65408; the smallest: 2^-24.
  EXPECT_EQ(pack_rgb9e5(Rgb{65408}), 511u | 511u << 9 | 511u << 18 | 31u << 27);
  EXPECT_EQ(unpack_rgb9e5(0xffffffffu), Rgb{65408});
  EXPECT_EQ(pack_rgb9e5({0x1p-24f, 0, 0}), 1u);
  EXPECT_EQ(unpack_rgb9e5(1u), (Rgb{0x1p-24f, 0, 0}));
}

TEST(Rgb9e5, WildNumbersAreClamped) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5({inf, 1e30f, 65408})), Rgb{65408});
  EXPECT_EQ(pack_rgb9e5({nan, -1, -inf}), 0u);
  EXPECT_EQ(pack_rgb9e5({0x1p-26f, 1e-40f, 0}), 0u);
}

TEST(Rgb9e5, EveryCodeWithATopBitSurvives) {
  // Codes whose exponent is the least possible are the canonical ones: packing gives them back.
  test::Random random(1);
  for (int i = 0; i < 200'000; ++i) {
    const uint32_t code = random.next_u32() | 1u << 8;  // red's top mantissa bit
    ASSERT_EQ(pack_rgb9e5(unpack_rgb9e5(code)), code);
  }
}

TEST(Rgb9e5, RoundsToWithinHalfAStepOfTheLargest) {
  test::Random random(2);
  for (int i = 0; i < 200'000; ++i) {
    const auto draw = [&] { return std::exp2(40 * random.next() - 24); };
    const Rgb c{draw(), draw(), draw()};
    const Rgb back = unpack_rgb9e5(pack_rgb9e5(c));
    const float top = std::min(max_component(c), 65408.0f);
    for (int k = 0; k < 3; ++k)
      ASSERT_NEAR(back[k], std::min(c[k], 65408.0f), top / 512 * 1.0001f + 0x1p-25f)
          << c.r << " " << c.g << " " << c.b;
  }
}

TEST(Rgb9e5, CarriesIntoTheExponent) {
  // Just under a power of two rounds up to it.
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5(Rgb{1.9999f})), Rgb{2.0f});
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5({0.99999f, 0.5f, 0.1f})).r, 1.0f);
}

}  // namespace
}  // namespace qray
