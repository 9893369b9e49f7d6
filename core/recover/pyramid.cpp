#include "core/recover/pyramid.h"

#include <array>
#include <cmath>
#include <utility>

namespace qray {
namespace {

constexpr int kC = kPyramidChannels;

constexpr std::array<PyramidLayer, kPyramidParts> kLayers = [] {
  std::array<PyramidLayer, kPyramidParts> layers{};
  layers[kFirstLayer] = {1, kPyramidInputs, kC, 0, 0};
  for (int part = kDown1; part <= kUp1; ++part)
    layers[static_cast<size_t>(part)] = {3, kC, kC, 0, 0};
  for (PyramidPart part : {kHead5, kHead4, kHead3, kHead2})
    layers[part] = {1, kC, kCellLogits, 0, 0};
  layers[kHead1] = {1, kC, 2 * kCellLogits, 0, 0};
  layers[kHead0] = {1, kC, kBlock * kCellLogits, 0, 0};
  size_t at = 0;
  for (PyramidLayer& layer : layers) {
    layer.weights = at;
    layer.bias = at + static_cast<size_t>(layer.side * layer.side * layer.inputs * layer.outputs);
    at = layer.bias + static_cast<size_t>(layer.outputs);
  }
  return layers;
}();

}  // namespace

PyramidLayer pyramid_layer(PyramidPart part) { return kLayers[static_cast<size_t>(part)]; }

size_t pyramid_scales() {
  const PyramidLayer& last = kLayers.back();
  return last.bias + static_cast<size_t>(last.outputs);
}

size_t pyramid_size() { return pyramid_scales() + size_t{kPyramidLevels * 2 * kDistances}; }

Network untrained_network(uint64_t seed) {
  std::vector<float> values(pyramid_size(), 0);
  for (int part = kFirstLayer; part <= kUp1; ++part) {
    const PyramidLayer layer = kLayers[static_cast<size_t>(part)];
    fill_at_random(std::span(values).subspan(layer.weights, layer.bias - layer.weights),
                   layer.side * layer.side * layer.inputs, seed);
  }
  for (size_t i = pyramid_scales(), k = 0; i < values.size(); ++i, ++k)
    values[i] = std::log(kFirstScales[k % kDistances]);
  return {std::move(values)};
}

}  // namespace qray
