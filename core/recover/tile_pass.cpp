#include "core/recover/tile_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

// A softmax: a filter's, or one of a pixel's of the block.
struct Group {
  int first, size;  // of the logits
  int scales;       // which set
};
constexpr int kGroups = kFilters + kBlock;
constexpr Group group(int g) {
  return g < kFilters ? Group{g * kTaps, kTaps, g}
                      : Group{kUpLogits + (g - kFilters) * kUpTaps, kUpTaps, kFilters};
}
constexpr size_t kBlockDistances = static_cast<size_t>(kGroups * kTaps * kDistances);

// The block that tap t of the filter reaches; pictures end in copies of their edge.
struct Reach {
  int height, width;
  size_t operator()(int y, int x, int t, int dilation) const {
    const int ty = std::clamp(y + (t / 3 - 1) * dilation, 0, height - 1);
    const int tx = std::clamp(x + (t % 3 - 1) * dilation, 0, width - 1);
    return static_cast<size_t>(ty) * static_cast<size_t>(width) + static_cast<size_t>(tx);
  }
};

// Where the unit was below 0, the gradient is kSlope of what it is.
void back_leaky(Grid& d, const Grid& layer) {
  for (size_t i = 0; i < d.data.size(); ++i)
    if (layer.data[i] < 0) d.data[i] *= kSlope;
}

}  // namespace

void TilePass::measure_distances(const BlockTile& tile) {
  distances_.resize(tile.blocks() * kBlockDistances);
  float* out = distances_.data();
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x)
      for (int g = 0; g < kGroups; ++g) {
        const float* pixel = tile.features(y, x, std::max(0, g - kFilters));
        const int dilation = g < kFilters ? kDilations[static_cast<size_t>(g)] : 1;
        for (int t = 0; t < kTaps; ++t) {
          const float* tap =
              tile.features(std::clamp(y + (t / 3 - 1) * dilation, 0, height_ - 1),
                            std::clamp(x + (t % 3 - 1) * dilation, 0, width_ - 1), 0);
          for (float d : feature_distances(pixel, tap)) *out++ = d;
        }
      }
}

void TilePass::make_kernels(const Network& net) {
  float scales[(kFilters + 1) * kDistances];
  for (size_t i = 0; i < std::size(scales); ++i)
    scales[i] = std::exp(net.values[net.parts().scales + i]);
  kernels_.resize(height_, width_, kLogits);
  const size_t blocks = kernels_.data.size() / kLogits;
  for (size_t b = 0; b < blocks; ++b) {
    const float* d = &distances_[b * kBlockDistances];
    for (int g = 0; g < kGroups; ++g) {
      const Group of = group(g);
      float* logits = &logits_.data[b * kLogits + static_cast<size_t>(of.first)];
      const float* scale = scales + of.scales * kDistances;
      for (int t = 0; t < kTaps; ++t)
        for (int k = 0; k < kDistances; ++k) logits[t] -= scale[k] * *d++;
      float most = logits[0], sum = 0;
      for (int t = 1; t < of.size; ++t) most = std::max(most, logits[t]);
      float e[kLanes] = {};
      for (int t = 0; t < of.size; ++t) e[t] = logits[t] - most;
      store(e, exp_lanes(load(e)));
      for (int t = 0; t < of.size; ++t) sum += e[t];
      float* kernel = &kernels_.data[b * kLogits + static_cast<size_t>(of.first)];
      for (int t = 0; t < of.size; ++t) kernel[t] = e[t] / sum;
    }
  }
}

void TilePass::filter(const BlockTile& tile) {
  const size_t blocks = tile.blocks();
  const Reach reach{height_, width_};
  filtered_[0] = tile.known;
  for (int f = 0; f < kFilters; ++f) {
    const std::vector<float>& from = filtered_[f];
    std::vector<float>& to = filtered_[f + 1];
    to.assign(3 * blocks, 0);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const size_t b =
            static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
        const float* kernel = &kernels_.data[b * kLogits + static_cast<size_t>(f * kTaps)];
        for (int t = 0; t < kTaps; ++t) {
          const size_t tap = reach(y, x, t, kDilations[static_cast<size_t>(f)]);
          for (size_t c = 0; c < 3; ++c) to[c * blocks + b] += kernel[t] * from[c * blocks + tap];
        }
      }
  }
  result_.assign(3 * kBlock * blocks, 0);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const size_t b =
          static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
      for (int s = 0; s < kBlock; ++s) {
        const float* kernel =
            &kernels_.data[b * kLogits + static_cast<size_t>(group(kFilters + s).first)];
        float* out = &result_[(b * kBlock + static_cast<size_t>(s)) * 3];
        for (size_t c = 0; c < 3; ++c) out[c] = kernel[kTaps] * tile.known[c * blocks + b];
        for (int t = 0; t < kTaps; ++t) {
          const size_t tap = reach(y, x, t, 1);
          for (size_t c = 0; c < 3; ++c)
            out[c] += kernel[t] * filtered_[kFilters][c * blocks + tap];
        }
      }
    }
}

std::span<const float> TilePass::forward(const Network& net, const BlockTile& tile) {
  const Network::Parts at = net.parts();
  const float* v = net.values.data();
  height_ = tile.height, width_ = tile.width;
  convolve(tile.input, 1, v + at.weights1, v + at.bias1, kSlope, net.hidden, layer1_);
  convolve(layer1_, 3, v + at.weights2, v + at.bias2, kSlope, net.hidden, layer2_);
  convolve(layer2_, 1, v + at.weights3, v + at.bias3, 1, kLogits, logits_);
  measure_distances(tile);
  make_kernels(net);
  filter(tile);
  return result_;
}

void TilePass::back_kernel(size_t block, int first, int n, const float* d_kernel) {
  const float* kernel = &kernels_.data[block * kLogits + static_cast<size_t>(first)];
  float* out = &d_logits_.data[block * kLogits + static_cast<size_t>(first)];
  float mean = 0;
  for (int t = 0; t < n; ++t) mean += kernel[t] * d_kernel[t];
  for (int t = 0; t < n; ++t) out[t] = kernel[t] * (d_kernel[t] - mean);
}

void TilePass::back_filters(const BlockTile& tile, std::span<const float> d_result) {
  const size_t blocks = tile.blocks();
  const Reach reach{height_, width_};
  for (std::vector<float>& d : d_filtered_) d.assign(3 * blocks, 0);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const size_t b =
          static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
      for (int s = 0; s < kBlock; ++s) {
        const Group of = group(kFilters + s);
        const float* kernel = &kernels_.data[b * kLogits + static_cast<size_t>(of.first)];
        const float* d = &d_result[(b * kBlock + static_cast<size_t>(s)) * 3];
        float d_kernel[kUpTaps] = {};
        for (int t = 0; t < kTaps; ++t) {
          const size_t tap = reach(y, x, t, 1);
          for (size_t c = 0; c < 3; ++c) {
            d_kernel[t] += d[c] * filtered_[kFilters][c * blocks + tap];
            d_filtered_[kFilters][c * blocks + tap] += d[c] * kernel[t];
          }
        }
        for (size_t c = 0; c < 3; ++c) d_kernel[kTaps] += d[c] * tile.known[c * blocks + b];
        back_kernel(b, of.first, of.size, d_kernel);
      }
    }
  for (int f = kFilters - 1; f >= 0; --f)
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const size_t b =
            static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
        const float* kernel = &kernels_.data[b * kLogits + static_cast<size_t>(f * kTaps)];
        float d_kernel[kTaps] = {};
        for (int t = 0; t < kTaps; ++t) {
          const size_t tap = reach(y, x, t, kDilations[static_cast<size_t>(f)]);
          for (size_t c = 0; c < 3; ++c) {
            const float d = d_filtered_[f + 1][c * blocks + b];
            d_kernel[t] += d * filtered_[f][c * blocks + tap];
            d_filtered_[f][c * blocks + tap] += d * kernel[t];
          }
        }
        back_kernel(b, f * kTaps, kTaps, d_kernel);
      }
}

void TilePass::back_scales(const Network& net, std::span<float> gradient) {
  double sums[(kFilters + 1) * kDistances] = {};
  const size_t blocks = d_logits_.data.size() / kLogits;
  for (size_t b = 0; b < blocks; ++b) {
    const float* distance = &distances_[b * kBlockDistances];
    for (int g = 0; g < kGroups; ++g) {
      const Group of = group(g);
      const float* d = &d_logits_.data[b * kLogits + static_cast<size_t>(of.first)];
      for (int t = 0; t < kTaps; ++t)
        for (int k = 0; k < kDistances; ++k)
          sums[of.scales * kDistances + k] -= static_cast<double>(d[t] * *distance++);
    }
  }
  const size_t first = net.parts().scales;
  for (size_t i = 0; i < std::size(sums); ++i)
    gradient[first + i] += static_cast<float>(sums[i]) * std::exp(net.values[first + i]);
}

void TilePass::backward(const Network& net, const BlockTile& tile, std::span<const float> d_result,
                        std::span<const float> back2, std::span<const float> back3,
                        std::span<float> gradient) {
  QRAY_CHECK(tile.height == height_ && tile.width == width_ && d_result.size() == result_.size());
  const Network::Parts at = net.parts();
  d_logits_.resize(height_, width_, kLogits);
  std::fill(d_logits_.data.begin(), d_logits_.data.end(), 0.0f);
  back_filters(tile, d_result);
  back_scales(net, gradient);

  float* g = gradient.data();
  add_weight_gradient(layer2_, 1, d_logits_, g + at.weights3, g + at.bias3);
  convolve(d_logits_, 1, back3.data(), nullptr, 1, net.hidden, d_layer2_);
  back_leaky(d_layer2_, layer2_);
  add_weight_gradient(layer1_, 3, d_layer2_, g + at.weights2, g + at.bias2);

  padded_.resize(height_ + 4, width_ + 4, net.hidden);
  std::fill(padded_.data.begin(), padded_.data.end(), 0.0f);
  for (int y = 0; y < height_; ++y)
    std::copy_n(d_layer2_.at(y, 0), width_ * net.hidden, padded_.at(y + 2, 2));
  convolve(padded_, 3, back2.data(), nullptr, 1, net.hidden, d_layer1_);
  back_leaky(d_layer1_, layer1_);
  add_weight_gradient(tile.input, 1, d_layer1_, g + at.weights1, g + at.bias1);
}

}  // namespace qray
