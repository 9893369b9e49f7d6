#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/recover/pyramid_pass.h"

namespace qray {
namespace {

// Gradients of what went on beyond the edges, back to these.
void fold(const CellPlanes& planes) {
  for (int y = 0; y < planes.height; ++y)
    for (int k = 0; k < planes.count; ++k) {
      float* row = planes.at(k, y);
      row[0] += row[-1];
      row[planes.width - 1] += row[planes.width];
      row[-1] = row[planes.width] = 0;
    }
}

// Weights [tap][input][output] -> those that take a gradient back to the input: [tap reversed]
// [output][input].
std::vector<float> transposed(const float* weights, int taps, int inputs, int outputs) {
  std::vector<float> back(static_cast<size_t>(taps) * static_cast<size_t>(inputs) *
                          static_cast<size_t>(outputs));
  for (int t = 0; t < taps; ++t)
    for (int i = 0; i < inputs; ++i)
      for (int o = 0; o < outputs; ++o)
        back[static_cast<size_t>(((taps - 1 - t) * outputs + o) * inputs + i)] =
            weights[static_cast<size_t>((t * inputs + i) * outputs + o)];
  return back;
}

// Where the unit was below 0, the gradient is kSlope of what it is.
void back_leaky(const CellGrid& d, const CellGrid& unit) {
  for (int y = 0; y < d.height; ++y) {
    float* to = d.at(y, 0);
    const float* from = unit.at(y, 0);
    for (int i = 0; i < d.width * d.channels; ++i) to[i] = from[i] < 0 ? kSlope * to[i] : to[i];
  }
}

}  // namespace

float* PyramidPass::d_coarsen_logit(int level, int y, int x) {
  if (level > 0) return d_head_[level].at(y, x) + kCoarsenLogit;
  return d_head_[1].at(y / 2, x / 2) + kPixelCoarsenLogits + 2 * (y % 2) + x % 2;
}

// By d_result of the level: d_colour of it, d_result of the coarser one, and d_head.
void PyramidPass::back_filter(int l, std::span<const float> scales, std::span<double> d_scales) {
  Level& level = levels_[l];
  ExpandedRows& coarse = scratch_[0].coarse;
  coarse.resize(level.width, kColour + kFeatures);
  ExpandedRows d_coarse;
  d_coarse.resize(level.width, kColour);
  std::vector<float> d_logits(static_cast<size_t>(coarse.pitch * kPyramidTaps));
  for (int y = 0; y < level.height; ++y) {
    BackFilterRow back;
    FilterRow& row = back.forward;
    row = filter_row(l, y, coarse);
    if (l < kLast)
      for (int i : {0, 1}) {
        std::fill(d_coarse.memory[i].begin(), d_coarse.memory[i].end(), 0.0f);
        back.d_coarse_colour[i] = d_coarse.row[i];
      }
    row.scales = scales.data();
    row.kernels = level.kernels.at(0, y);
    back.d_out = level.d_result.at(0, y);
    back.d_colour = level.d_colour;
    back.d_logits = d_logits.data();
    back.d_scales = d_scales.data();
    loops_->back_filter_row(back);
    if (l < kLast)
      for (int slot : {0, 1})
        d_coarse.add_back(levels_[l + 1].d_result,
                          ExpandedRows::nearest(y, slot, levels_[l + 1].height), slot);
    const int taps = l < kLast ? kPyramidTaps : kTaps;
    for (int x = 0; x < level.width; ++x) {
      float* to = l > 0 ? d_head_[l].at(y, x)
                        : d_head_[0].at(y / 2, x / 2) + (2 * (y % 2) + x % 2) * kCellLogits;
      for (int t = 0; t < taps; ++t) to[t] = d_logits[static_cast<size_t>(t * coarse.pitch + x)];
    }
  }
  fold(level.d_colour);
}

// By d_colour of the level: that of the finer one, and the logits by which its cells count.
void PyramidPass::back_coarsen(int l) {
  Level &fine = levels_[l - 1], &level = levels_[l];
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x) {
      float d_count[kBlock], mean = 0;
      for (int s = 0; s < kBlock; ++s) {
        const int fy = 2 * y + s / 2, fx = 2 * x + s % 2;
        const float count = fine.counts.at(0, fy)[fx];
        d_count[s] = 0;
        for (int c = 0; c < kColour; ++c) {
          const float d = level.d_colour.at(c, y)[x];
          d_count[s] += d * fine.colour.at(c, fy)[fx];
          fine.d_colour.at(c, fy)[fx] += d * count;
        }
        mean += count * d_count[s];
      }
      for (int s = 0; s < kBlock; ++s) {
        const int fy = 2 * y + s / 2, fx = 2 * x + s % 2;
        *d_coarsen_logit(l - 1, fy, fx) = fine.counts.at(0, fy)[fx] * (d_count[s] - mean);
      }
    }
}

// d_out: by the layer's result; becomes that before its leaky unit, if it has one and so `out` is
// not null. d_in is written, if wanted.
void PyramidPass::back_layer(std::span<const float> values, PyramidPart part, const Cells& in,
                             const Cells* out, Cells& d_out, Cells* d_in,
                             std::span<float> gradient) {
  const PyramidLayer layer = pyramid_layer(part);
  if (out) back_leaky(d_out, *out);
  loops_->add_weight_gradient(in, layer, d_out, &gradient[layer.weights], &gradient[layer.bias]);
  if (!d_in) return;
  const std::vector<float> back =
      transposed(&values[layer.weights], layer.side * layer.side, layer.inputs, layer.outputs);
  const PyramidLayer turned{layer.side, layer.outputs, layer.inputs, 0, 0};
  d_in->resize(in.height, in.width, layer.inputs);
  for (int y = 0; y < in.height; ++y)
    loops_->convolve_row(d_out, turned, back.data(), nullptr, 1, *d_in, y);
}

void PyramidPass::backward(std::span<const float> values, std::span<const float> d_result,
                           std::span<float> gradient) {
  QRAY_CHECK(d_result.size() == static_cast<size_t>(width_ * height_ * kColour));
  for (int l = 0; l < kPyramidLevels; ++l) {
    Level& level = levels_[l];
    for (Plane* d : {&level.d_colour, &level.d_result}) {
      d->resize_unset(level.height, level.width, kColour);
      d->clear();
    }
    const PyramidLayer head = pyramid_layer(kHeadParts[l]);
    d_head_[l].resize(levels_[std::max(l, 1)].height, levels_[std::max(l, 1)].width, head.outputs);
  }
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x)
      for (int c = 0; c < kColour; ++c)
        levels_[0].d_result.at(c, y)[x] =
            d_result[static_cast<size_t>((y * width_ + x) * kColour + c)];

  // The filters.
  constexpr size_t kScales = 2 * kDistances;
  for (size_t l = 0; l < kPyramidLevels; ++l) {
    float scales[kScales];
    double d_scales[kScales] = {};
    const size_t first = pyramid_scales() + l * kScales;
    for (size_t k = 0; k < kScales; ++k) scales[k] = std::exp(values[first + k]);
    back_filter(static_cast<int>(l), scales, d_scales);
    for (size_t k = 0; k < kScales; ++k)
      gradient[first + k] += static_cast<float>(d_scales[k]) * scales[k];
  }
  for (int l = kLast; l >= 1; --l) back_coarsen(l);

  // The layers, from level 1 down: d_up_ of a level is known when that of the finer one was made.
  const auto add = [](const Cells& to, const Cells& from) {
    for (int y = 0; y < to.height; ++y)
      for (int i = 0; i < to.width * to.channels; ++i) to.at(y, 0)[i] += from.at(y, 0)[i];
  };
  Cells& d_head_in = d_pooled_[0];
  for (int l = 1; l <= kLast; ++l) {
    const Cells& unit = unit_of(l);
    Cells& d_unit = l < kLast ? d_up_[l] : d_down_[l];
    d_unit.resize(unit.height, unit.width, unit.channels);
    for (int y = 0; y < unit.height; ++y)
      for (int x = 0; x < unit.width; ++x)
        for (int k = 0; k < kPyramidChannels; ++k) {
          float sum = 0;  // of the four cells that the coarser one was added to
          if (l > 1)
            for (int s = 0; s < kBlock; ++s)
              sum += d_sum_[l - 1].at(2 * y + s / 2, 2 * x + s % 2)[k];
          d_unit.at(y, x)[k] = sum;
        }
    if (l == 1) {
      back_layer(values, kHead0, unit, nullptr, d_head_[0], &d_head_in, gradient);
      add(d_unit, d_head_in);
    }
    back_layer(values, kHeadParts[l], unit, nullptr, d_head_[l], &d_head_in, gradient);
    add(d_unit, d_head_in);
    if (l < kLast)
      back_layer(values, kUpParts[l], sum_[l], &up_[l], d_up_[l], &d_sum_[l], gradient);
  }
  for (int l = kLast; l >= 1; --l) {
    if (l < kLast) {  // by the sum, and by what was made of its mean
      d_down_[l].resize(down_[l].height, down_[l].width, kPyramidChannels);
      for (int y = 0; y < down_[l].height; ++y)
        for (int x = 0; x < down_[l].width; ++x)
          for (int k = 0; k < kPyramidChannels; ++k)
            d_down_[l].at(y, x)[k] =
                d_sum_[l].at(y, x)[k] + 0.25f * d_pooled_[l + 1].at(y / 2, x / 2)[k];
    }
    back_layer(values, kDownParts[l], l == 1 ? first_ : pooled_[l], &down_[l], d_down_[l],
               l == 1 ? &d_first_ : &d_pooled_[l], gradient);
  }
  back_layer(values, kFirstLayer, input_, &first_, d_first_, nullptr, gradient);
}

}  // namespace qray
