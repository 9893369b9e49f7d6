#include "core/recover/fast_recovery.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/recover/tile_pass.h"
#include "core/recover/training_view.h"
#include "tests/support/random.h"

namespace qray {
namespace {

Image random_image(int width, int height, int channels, uint64_t seed) {
  test::Random random(seed);
  Image image(width, height, channels);
  for (float& v : image.data()) v = random.next();
  return image;
}

double largest_difference(int hidden, int width, int height, FastRecovery::Target target) {
  Image features = random_image(width, height, kFeatures, 1);
  for (float& v : features.data()) v = 0.5f + 0.1f * v;
  const Image input = random_image(width, height, 3, 2), noise = random_image(width, height, 1, 3);
  Network net = untrained_network(hidden, 4);
  test::Random random(5);
  for (float& v : net.values) v += 0.1f * (random.next() - 0.5f);

  const BlockTile tile = tile_of(features, input, noise, 0, 0, height / 2, width / 2);
  TilePass pass;
  const std::span<const float> expected = pass.forward(net, tile);
  TaskPool pool(2);
  FastRecovery fast(net, width, height, target);
  fast.run(Image(width, height, kFeatures), input, noise, pool);  // leaves nothing behind
  const Image image = fast.run(features, input, noise, pool);
  double largest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const size_t block = static_cast<size_t>(y / 2 * (width / 2) + x / 2);
        const size_t i =
            (block * kBlock + static_cast<size_t>(y % 2 * 2 + x % 2)) * 3 + static_cast<size_t>(c);
        const double e = static_cast<double>(expected[i] * tile.albedo[i]);
        largest = std::max(largest, std::abs(static_cast<double>(image.at(x, y, c)) - e) / (1 + e));
      }
  return largest;
}

TEST(FastRecovery, MakesWhatTheReferenceMakes) {
  for (const auto target : {FastRecovery::Target::kBest, FastRecovery::Target::kCommon})
    for (const int hidden : {16, 32})
      for (const auto& [width, height] : {std::pair{64, 32}, {70, 38}, {2, 2}, {34, 6}, {34, 400}})
        EXPECT_LT(largest_difference(hidden, width, height, target), 1e-6)
            << hidden << " hidden, " << width << "x" << height;
}

}  // namespace
}  // namespace qray
