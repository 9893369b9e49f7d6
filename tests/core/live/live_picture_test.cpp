#include "core/live/live_picture.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/recover/included_networks.h"

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

// A view of one surface of which all pixels have `samples`.
struct OneSurface {
  ViewBuffer view;
  History history{32 * 32};

  OneSurface(float samples, const std::function<float(int, int)>& light_of) {
    view.width = view.height = 32;
    view.features = Image(32, 32, kFeatureChannels);
    view.surfaces.assign(32 * 32, 1);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const size_t i = view.index(x, y);
        for (int c = 0; c < 3; ++c) view.features.at(x, y, c) = 0.5f;
        view.features.at(x, y, 5) = 1;  // the normal
        const float light = light_of(x, y);
        history[i] = {Rgb{light}, samples * light * light, samples};  // of one sample among them
      }
  }
  // That recovery makes of it.
  Image picture() {
    TaskPool pool(2);
    Guess recovery(included_network("untrained").value());
    const History known = history;
    return recovered_picture(view, known, BlockGrid(view, known, pool), false, recovery, history,
                             pool);
  }
};

Image recovered(float samples, const std::function<float(int, int)>& light_of) {
  return OneSurface(samples, light_of).picture();
}

TEST(RecoveredPicture, ItsGuessIsAMeanOverTheLastFrames) {
  OneSurface black(0, [](int, int) { return 0.0f; });
  for (PixelHistory& h : black.history) h.guess = Rgb{1}, h.guesses = 10;
  const Image picture = black.picture();
  const float mean = kMostGuesses / (kMostGuesses + 1);
  EXPECT_NEAR(picture.at(9, 20, 1), mean * (0.5f + kAlbedoFloor), 1e-5);
  EXPECT_NEAR(black.history[5].guess.g, mean, 1e-5);
  EXPECT_EQ(black.history[5].guesses, kMostGuesses + 1);
}

// Of eight samples a pixel one in sixteen pixels' was bright, and all in a square had none.
TEST(RecoveredPicture, BlackSamplesAreNotSureThatThereIsNoLight) {
  const auto dark = [](int x, int y) { return x >= 8 && x < 24 && y >= 8 && y < 24; };
  const Image picture = recovered(
      8, [&](int x, int y) { return !dark(x, y) && x % 4 == 1 && y % 4 == 1 ? 16.0f : 0.0f; });
  double inside = 0, outside = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      (dark(x, y) ? inside : outside) += static_cast<double>(picture.at(x, y, 0));
  inside /= 256, outside /= 768;
  EXPECT_GT(inside, outside / 10);
}

// The pixel's own samples tell that the light is one bright sample's.
TEST(RecoveredPicture, ARareBrightSampleIsNoise) {
  const Image picture =
      recovered(8, [](int x, int y) { return x == 16 && y == 16 ? 100.0f : 1.0f; });
  EXPECT_LT(picture.at(16, 16, 0), 5);
}

}  // namespace
}  // namespace qray
