#include "core/recover/tile_pass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/recover/loss.h"
#include "core/recover/training_view.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kTileSide = 24;  // pixels

struct Pictures {
  Image features{kTileSide, kTileSide, kFeatures}, input{kTileSide, kTileSide, 3},
      noise{kTileSide, kTileSide, 1}, target{kTileSide, kTileSide, 3};
};

Pictures random_pictures(uint64_t seed) {
  test::Random random(seed);
  Pictures p;
  for (Image* image : {&p.features, &p.input, &p.noise, &p.target})
    for (float& v : image->data()) v = random.next();
  // Features as near to one another as neighbours' are.
  for (float& v : p.features.data()) v = 0.5f + 0.05f * v;
  return p;
}

BlockTile tile(const Pictures& p) {
  return tile_of(p.features, p.input, p.noise, 0, 0, kTileSide / 2, kTileSide / 2);
}

Network shaken(int hidden, uint64_t seed) {
  test::Random random(seed);
  Network net = untrained_network(hidden, seed);
  for (float& v : net.values) v += 0.1f * (random.next() - 0.5f);
  return net;
}

TEST(TilePass, GradientsAreThoseOfFiniteDifferences) {
  for (const int hidden : {16, 32}) {
    const Pictures p = random_pictures(3);
    const BlockTile t = tile(p);
    const std::vector<float> target =
        target_of({{p.features, p.input, p.noise}, p.target}, 0, 0, t.height, t.width, {});
    Network net = shaken(hidden, 5);
    const Network::Parts at = net.parts();
    TilePass pass;
    std::vector<float> d_result, gradient(net.values.size(), 0), unused;
    const std::span<const float> first = pass.forward(net, t);
    const std::vector<float> start(first.begin(), first.end());
    relative_squared_loss(start, t.albedo, target, d_result);
    pass.backward(net, t, d_result, transposed(&net.values[at.weights2], kTaps, hidden, hidden),
                  transposed(&net.values[at.weights3], 1, hidden, kLogits), gradient);
    // By the loss' own gradient, so that only the network is differentiated.
    const auto along = [&](size_t i, float by) {
      const float kept = net.values[i];
      net.values[i] = kept + by;
      const std::span<const float> y = pass.forward(net, t);
      double sum = 0;
      for (size_t k = 0; k < y.size(); ++k)
        sum += static_cast<double>(d_result[k]) * static_cast<double>(y[k] - start[k]);
      net.values[i] = kept;
      return sum;
    };
    test::Random random(11);
    double largest = 0;
    for (float g : gradient) largest = std::max(largest, static_cast<double>(std::abs(g)));
    const size_t parts[] = {at.weights1, at.bias1, at.weights2, at.bias2,
                            at.weights3, at.bias3, at.scales,   at.size};
    for (size_t part = 0; part + 1 < std::size(parts); ++part)
      for (int k = 0; k < 12; ++k) {
        const size_t i =
            parts[part] +
            static_cast<size_t>(random.next() * static_cast<float>(parts[part + 1] - parts[part]));
        constexpr float kStep = 2e-3f;
        const double slope = (along(i, kStep) - along(i, -kStep)) / (2 * double{kStep});
        EXPECT_NEAR(gradient[i], slope, 0.02 * std::abs(slope) + 1e-3 * largest)
            << "value " << i << " of part " << part << ", hidden " << hidden;
      }
  }
}

TEST(TilePass, InventsNothing) {
  Pictures p = random_pictures(7);
  for (float& v : p.features.data()) v = 0.5f;  // one albedo
  const BlockTile t = tile(p);
  TilePass pass;
  const std::span<const float> result = pass.forward(shaken(16, 2), t);
  for (size_t c = 0; c < 3; ++c) {
    const auto first = t.known.begin() + static_cast<std::ptrdiff_t>(c * t.blocks());
    const auto [low, high] =
        std::minmax_element(first, first + static_cast<std::ptrdiff_t>(t.blocks()));
    for (size_t i = c; i < result.size(); i += 3) {
      ASSERT_GE(result[i], *low - 1e-5f);
      ASSERT_LE(result[i], *high + 1e-5f);
    }
  }
}

TEST(TilePass, APictureOfOneColourStaysOne) {
  Pictures p = random_pictures(9);
  for (int y = 0; y < kTileSide; ++y)
    for (int x = 0; x < kTileSide; ++x)
      for (int c = 0; c < 3; ++c)
        p.input.at(x, y, c) = 0.7f * (p.features.at(x, y, c) + kAlbedoFloor);
  const BlockTile t = tile(p);
  TilePass pass;
  for (float v : pass.forward(shaken(16, 4), t)) ASSERT_NEAR(v, 0.7f, 1e-5f);
}

TEST(TilePass, UntrainedItKeepsAnEdgeOfTheFeatures) {
  Pictures p = random_pictures(1);
  for (int y = 0; y < kTileSide; ++y)
    for (int x = 0; x < kTileSide; ++x) {
      const bool left = x < kTileSide / 2;
      for (int k = 0; k < kFeatures; ++k) p.features.at(x, y, k) = 0.5f;
      for (int k = 0; k < 3; ++k)
        p.features.at(x, y, kFeatureNormal + k) = (k == 0) == left ? 1.0f : 0.0f;
      for (int c = 0; c < 3; ++c) p.input.at(x, y, c) = left ? 1.0f : 0.0f;
    }
  const BlockTile t = tile(p);
  TilePass pass;
  const std::span<const float> result = pass.forward(untrained_network(16, 1), t);
  for (size_t b = 0; b < t.blocks(); ++b)
    for (size_t s = 0; s < kBlock; ++s) {
      const float expected = b % static_cast<size_t>(t.width) < static_cast<size_t>(t.width) / 2
                                 ? 1 / (0.5f + kAlbedoFloor)
                                 : 0.0f;
      ASSERT_NEAR(result[(b * kBlock + s) * 3], expected, 0.01f);
    }
}

}  // namespace
}  // namespace qray
