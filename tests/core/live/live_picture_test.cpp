#include "core/live/live_picture.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

constexpr int kBlocks = 11;  // a side: more than the noise of one block looks at

// Of a view whose features are not known: each pixel has `samples`, of the light and its
// luminance's mean square that `light_of` gives for its block.
template <typename LightOf>
BlockGrid grid(float samples, const LightOf& light_of) {
  ViewBuffer view;
  view.width = view.height = 2 * kBlocks;
  History history(static_cast<size_t>(view.width * view.height));
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const auto [light, square] = light_of(x / 2, y / 2);
      history[view.index(x, y)] = {Rgb{light}, square, samples};
    }
  TaskPool pool(2);
  return BlockGrid(view, history, pool);
}

TEST(BlockGrid, SamplesThatAreAlikeAreSureWhereThoseAroundAreToo) {
  const BlockGrid even = grid(1, [](int, int) { return std::pair{0.5f, 0.25f}; });
  EXPECT_NEAR(even.at(5, 5).variance, 0, 1e-6);
}

// Most samples see no lamp: four dark ones do not make a block black for sure.
TEST(BlockGrid, FewDarkSamplesBesideABrightBlockAreNotSure) {
  constexpr float kBright = 25;
  const BlockGrid dark = grid(1, [](int x, int y) {
    const float light = x == 5 && y == 5 ? kBright : 0;
    return std::pair{light, light * light};
  });
  // Of 25 blocks' 100 samples four are bright: mean 1, mean square 25; each block by itself is
  // sure, by 75 samples beyond the first of each block, and 8 say what all together do.
  EXPECT_NEAR(dark.at(6, 6).variance, 8 * 24.0f / (75 + 8), 1e-3);
  EXPECT_NEAR(dark.at(0, 0).variance, 0, 1e-6);  // too far away
}

TEST(BlockGrid, WithManySamplesBlocksTellTheirNoiseThemselves) {
  // Light that grows from block to block, around which each block's samples have variance 1.
  const BlockGrid ramp = grid(1000, [](int x, int) {
    const auto light = static_cast<float>(x);
    return std::pair{light, light * light + 1};
  });
  EXPECT_NEAR(ramp.at(5, 5).variance, 1, 0.01);
}

}  // namespace
}  // namespace qray
