#include "core/recover/pyramid_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/recover/loss.h"
#include "tests/support/random.h"

namespace qray {
namespace {

struct PyramidPictures {
  RecoveryInput pictures;
  PyramidPictures(int width, int height, uint64_t seed)
      : pictures{Image(width, height, kFeatures), Image(width, height, 3), Image(width, height, 1),
                 Image(width, height, 1), Image(width, height, 3)} {
    test::Random random(seed);
    for (Image* image : {&pictures.features, &pictures.colour, &pictures.noise, &pictures.own_error,
                         &pictures.shown})
      for (float& v : image->data()) v = random.next();
    // Features as near to one another as neighbours' are.
    for (float& v : pictures.features.data()) v = 0.5f + 0.05f * v;
  }
  PyramidInput input() const { return {pictures, 1}; }
};

std::vector<float> shaken(uint64_t seed) {
  test::Random random(seed);
  std::vector<float> values = untrained_network(seed).values;
  for (float& v : values) v += 0.1f * (random.next() - 0.5f);
  return values;
}

TEST(PyramidPass, GradientsAreThoseOfFiniteDifferences) {
  // Not a multiple of the coarsest cells, so that what goes on beyond the edges counts too. Light
  // and gradients that differ from cell to cell of all levels: sums over noise alone would leave
  // the coarse levels nothing but rounding.
  constexpr int kWidth = 84, kHeight = 52;
  PyramidPictures p(kWidth, kHeight, 3);
  const auto uneven = [](int x, int y) { return (x / 7 + y / 5) % 2 + (x / 40 + y / 30) % 2; };
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        p.pictures.colour.at(x, y, c) *= static_cast<float>(1 + 2 * uneven(x, y));
  std::vector<float> values = shaken(5), gradient(values.size(), 0), d_result;
  PyramidPass pass;
  const Image start = pass.forward(values, p.input(), nullptr, true);
  test::Random random(11);
  for (int i = 0; i < kWidth * kHeight * 3; ++i)
    d_result.push_back(random.next() - 0.5f +
                       static_cast<float>(uneven(i / 3 % kWidth, i / 3 / kWidth) - 1));
  pass.backward(values, d_result, gradient);
  const auto along = [&](size_t i, float by) {
    const float kept = values[i];
    values[i] = kept + by;
    const Image y = pass.forward(values, p.input(), nullptr, false);
    double sum = 0;
    for (size_t k = 0; k < d_result.size(); ++k)
      sum += static_cast<double>(d_result[k]) *
             (static_cast<double>(y.data()[k]) - static_cast<double>(start.data()[k]));
    values[i] = kept;
    return sum;
  };
  std::vector<size_t> begins;
  for (int part = 0; part < kPyramidParts; ++part) {
    const PyramidLayer layer = pyramid_layer(static_cast<PyramidPart>(part));
    begins.push_back(layer.weights);
    begins.push_back(layer.bias);
  }
  begins.push_back(pyramid_scales());
  begins.push_back(pyramid_size());
  for (size_t part = 0; part + 1 < begins.size(); ++part) {
    double largest = 0;
    for (size_t i = begins[part]; i < begins[part + 1]; ++i)
      largest = std::max(largest, static_cast<double>(std::abs(gradient[i])));
    EXPECT_GT(largest, 0) << "part " << part;
    for (int k = 0; k < 6; ++k) {
      const size_t i =
          begins[part] +
          static_cast<size_t>(random.next() * static_cast<float>(begins[part + 1] - begins[part]));
      // Heads and scales are smooth, and change little; units of layers have bends.
      const float step = begins[part] < pyramid_layer(kHead5).weights ? 1e-3f : 0.1f;
      // At a bend of a unit the two sides differ: the gradient is one of them, or between.
      const double up = along(i, step) / static_cast<double>(step),
                   down = -along(i, -step) / static_cast<double>(step);
      const double room = 0.02 * std::max(std::abs(up), std::abs(down)) + 0.02 * largest;
      EXPECT_GE(gradient[i], std::min(up, down) - room) << "value " << i << " of part " << part;
      EXPECT_LE(gradient[i], std::max(up, down) + room) << "value " << i << " of part " << part;
    }
  }
}

TEST(PyramidPass, InventsNothing) {
  const PyramidPictures p(50, 34, 7);
  PyramidPass pass;
  const Image result = pass.forward(shaken(2), p.input(), nullptr, false);
  for (int c = 0; c < 3; ++c) {
    float low = 1e30f, high = 0;
    for (int y = 0; y < result.height(); ++y)
      for (int x = 0; x < result.width(); ++x) {
        const float light =
            p.pictures.colour.at(x, y, c) / (p.pictures.features.at(x, y, c) + kAlbedoFloor);
        low = std::min(low, light), high = std::max(high, light);
      }
    for (int y = 0; y < result.height(); ++y)
      for (int x = 0; x < result.width(); ++x) {
        ASSERT_GE(result.at(x, y, c), low - 1e-5f);
        ASSERT_LE(result.at(x, y, c), high + 1e-5f);
      }
  }
}

TEST(PyramidPass, UntrainedItKeepsAnEdgeOfTheFeatures) {
  PyramidPictures p(48, 32, 1);
  const int edge = 21;  // within a cell of every level
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      for (int k = 0; k < kFeatures; ++k) {
        const bool left = x < edge;
        p.pictures.features.at(x, y, k) =
            k >= kFeatureNormal && k < kFeatureDepth ? (k == kFeatureNormal) == left : 0.5f;
        if (k < 3) p.pictures.colour.at(x, y, k) = left ? 0.5f + kAlbedoFloor : 0;
      }
  PyramidPass pass;
  const Image result = pass.forward(untrained_network(1).values, p.input(), nullptr, false);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      ASSERT_NEAR(result.at(x, y, 0), x < edge ? 1 : 0, 0.05f) << x << ", " << y;
}

TEST(PyramidPass, AnyProcessorMakesTheSamePicture) {
  const PyramidPictures p(100, 70, 9);
  const std::vector<float> values = shaken(4);
  PyramidPass best, common(PyramidPass::Target::kCommon);
  const Image a = best.forward(values, p.input(), nullptr, false),
              b = common.forward(values, p.input(), nullptr, false);
  for (size_t i = 0; i < a.data().size(); ++i) ASSERT_NEAR(a.data()[i], b.data()[i], 1e-4f);
}

TEST(PyramidPass, AnyNumberOfThreadsMakesTheSameBits) {
  const PyramidPictures p(100, 70, 9);
  const std::vector<float> values = shaken(4);
  PyramidPass one, many;
  TaskPool pool(3);
  const Image a = one.forward(values, p.input(), nullptr, false),
              b = many.forward(values, p.input(), &pool, false);
  EXPECT_TRUE(std::ranges::equal(a.data(), b.data()));
}

// The layers against sums written as they are defined.
TEST(PyramidPass, ConvolutionsAreSumsOverTaps) {
  constexpr int kHeight = 5, kWidth = 21;
  test::Random random(3);
  for (const PyramidPart part : {kFirstLayer, kDown2, kHead2, kHead0}) {
    const PyramidLayer layer = pyramid_layer(part);
    const auto grid = [&](std::vector<float>& memory, int channels) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(kWidth + 2) * channels;
      memory.assign(static_cast<size_t>(row) * (kHeight + 2), 0);
      return CellGrid{memory.data() + row + channels, row, kHeight, kWidth, channels};
    };
    std::vector<float> in_memory, out_memory;
    const CellGrid in = grid(in_memory, layer.inputs), out = grid(out_memory, layer.outputs);
    for (int y = 0; y < kHeight; ++y)
      for (int i = 0; i < kWidth * layer.inputs; ++i) in.at(y, 0)[i] = random.next() - 0.5f;
    std::vector<float> values(pyramid_size());
    for (float& v : values) v = random.next() - 0.5f;
    for (int y = 0; y < kHeight; ++y)
      common_pyramid_loops().convolve_row(in, layer, &values[layer.weights], &values[layer.bias],
                                          kSlope, out, y);
    const int half = layer.side / 2;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int o = 0; o < layer.outputs; ++o) {
          double sum = values[layer.bias + static_cast<size_t>(o)];
          size_t w = layer.weights + static_cast<size_t>(o);
          for (int ky = -half; ky <= half; ++ky)
            for (int kx = -half; kx <= half; ++kx)
              for (int i = 0; i < layer.inputs; ++i, w += static_cast<size_t>(layer.outputs))
                sum += double{values[w]} * double{in.at(y + ky, x + kx)[i]};
          ASSERT_NEAR(out.at(y, x)[o], sum < 0 ? double{kSlope} * sum : sum, 1e-4);
        }
  }
}

}  // namespace
}  // namespace qray
