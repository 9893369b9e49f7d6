#include "core/recover/pyramid_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

constexpr int kLast = kPyramidLevels - 1;
constexpr PyramidPart kDownParts[] = {kFirstLayer, kDown1, kDown2, kDown3, kDown4, kDown5};
constexpr PyramidPart kUpParts[] = {kFirstLayer, kUp1, kUp2, kUp3, kUp4};
constexpr PyramidPart kHeadParts[] = {kHead0, kHead1, kHead2, kHead3, kHead4, kHead5};
// Of colours as the network sees them: nearly linear up to a tenth of the mean.
constexpr float kLogScale = 10, kLogShare = 0.3f;
constexpr float kLeastLight = 1e-3f;
constexpr float kUnknown = std::numeric_limits<float>::infinity();

// A row of planes goes on beyond its edges.
void extend(const CellPlanes& planes, int y) {
  for (int k = 0; k < planes.count; ++k) {
    float* row = planes.at(k, y);
    row[-1] = row[0];
    row[planes.width] = row[planes.width - 1];
  }
}

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

// in: 4 cells' means.
void pool_row(const CellGrid& in, const CellGrid& out, int y) {
  for (int x = 0; x < out.width; ++x) {
    const float *a = in.at(2 * y, 2 * x), *b = in.at(2 * y, 2 * x + 1),
                *c = in.at(2 * y + 1, 2 * x), *d = in.at(2 * y + 1, 2 * x + 1);
    float* o = out.at(y, x);
    for (int k = 0; k < kPyramidChannels; ++k) o[k] = 0.25f * ((a[k] + b[k]) + (c[k] + d[k]));
  }
}

void sum_row(const CellGrid& fine, const CellGrid& coarse, const CellGrid& out, int y) {
  for (int x = 0; x < out.width; ++x) {
    const float *a = fine.at(y, x), *b = coarse.at(y / 2, x / 2);
    float* o = out.at(y, x);
    for (int k = 0; k < kPyramidChannels; ++k) o[k] = a[k] + b[k];
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

bool has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

PyramidPass::PyramidPass(Target target)
    : loops_(target == Target::kBest && has_avx512() ? &avx512_pyramid_loops()
                                                     : &common_pyramid_loops()) {}

// Two rows of a coarser level, each cell twice; made again only where they are others.
struct PyramidPass::Expanded {
  std::ptrdiff_t pitch;
  std::vector<float> memory[2];
  float* row[2] = {};

  Expanded(int width, int planes) : pitch(row_pitch(width)) {
    for (int i = 0; i < 2; ++i) {
      memory[i].assign(static_cast<size_t>(pitch * planes) + 2 * kLanes, 0);
      row[i] = memory[i].data() + kLanes;
    }
  }
  void expand(const CellPlanes& from, int y, int slot, int plane) {
    for (int k = 0; k < from.count; ++k) {
      const float* in = from.at(k, y);
      float* out = row[slot] + (plane + k) * pitch;
      for (int x = 0; x < from.width; ++x) out[2 * x] = out[2 * x + 1] = in[x];
      out[-1] = in[0];
      out[2 * from.width] = in[from.width - 1];
    }
  }
  // Gradients of the first planes, back to the cells.
  void add_back(const CellPlanes& to, int y, int slot) const {
    for (int k = 0; k < to.count; ++k) {
      const float* in = row[slot] + k * pitch;
      float* out = to.at(k, y);
      for (int x = 0; x < to.width; ++x) out[x] += in[2 * x] + in[2 * x + 1];
      out[0] += in[-1];
      out[to.width - 1] += in[2 * to.width];
    }
  }
  // The two nearest rows of the coarser level, of `height`.
  static int nearest(int y, int slot, int height) {
    return std::clamp((y + 2 * slot - 1) >> 1, 0, height - 1);
  }
};

void PyramidPass::pack(const PyramidInput& input, TaskPool* pool) {
  const RecoveryInput& pictures = input.pictures;
  const int width = pictures.colour.width(), height = pictures.colour.height();
  width_ = width, height_ = height;
  const bool shows = !pictures.shown.empty(), knows_own = !pictures.own_error.empty();
  const auto whole = [](int n) { return (n + kPyramidSide - 1) / kPyramidSide * kPyramidSide; };
  for (int l = 0; l < kPyramidLevels; ++l) {
    Level& level = levels_[l];
    level.height = whole(height) >> l, level.width = whole(width) >> l;
    level.colour.resize(level.height, level.width, kColour, pool);
    level.features.resize(level.height, level.width, kFeatures, pool);
    level.result.resize(level.height, level.width, kColour, pool);
    if (l < kLast) level.counts.resize(level.height, level.width, 1, pool);
  }
  const Level& fine = levels_[0];
  input_.resize(fine.height / 2, fine.width / 2, kPyramidInputs, pool);
  for_rows(pool, fine.height, [&](int y) {
    const int py = std::min(y, height - 1);
    for (int x = 0; x < fine.width; ++x) {
      const int px = std::min(x, width - 1);
      const float* f =
          &pictures.features.data()[(static_cast<size_t>(py) * static_cast<size_t>(width) +
                                     static_cast<size_t>(px)) *
                                    kFeatures];
      float* in = input_.at(y / 2, x / 2) + (2 * (y % 2) + x % 2) * kPixelInputs;
      for (int c = 0; c < kColour; ++c) {
        const float light = pictures.colour.at(px, py, c) / (f[c] + kAlbedoFloor);
        fine.colour.at(c, y)[x] = light;
        in[c] = kLogShare * std::log(1 + kLogScale * light * input.exposure);
      }
      in[kPixelNoise] = pictures.noise.at(px, py, 0);
      const float own = knows_own ? pictures.own_error.at(px, py, 0) : kUnknown;
      const float light = luminance(pictures.colour.rgb(px, py)) + kLeastLight;
      in[kPixelOwnNoise] = std::isfinite(own) ? own / (own + light) : 1;
      const float shown = shows ? luminance(pictures.shown.rgb(px, py)) : 0;
      in[kPixelShown] = shown / (1 + shown);
      for (int k = 0; k < kFeatures; ++k) {
        in[kPixelFeatures + k] = f[k];
        fine.features.at(k, y)[x] = f[k];
      }
    }
    extend(fine.colour, y);
    extend(fine.features, y);
  });
  for (int l = 1; l < kPyramidLevels; ++l)
    for_rows(pool, levels_[l].height, [&](int y) {
      const CellPlanes &from = levels_[l - 1].features, &to = levels_[l].features;
      for (int k = 0; k < kFeatures; ++k) {
        const float *a = from.at(k, 2 * y), *b = from.at(k, 2 * y + 1);
        float* out = to.at(k, y);
        for (int x = 0; x < to.width; ++x)
          out[x] = 0.25f * ((a[2 * x] + a[2 * x + 1]) + (b[2 * x] + b[2 * x + 1]));
      }
      extend(to, y);
    });
}

void PyramidPass::run_layer(std::span<const float> values, PyramidPart part, const Cells& in,
                            Cells& out, TaskPool* pool) const {
  const PyramidLayer layer = pyramid_layer(part);
  out.resize(in.height, in.width, layer.outputs, pool);
  const float slope = part >= kHead5 ? 1.0f : kSlope;
  for_rows(pool, in.height, [&](int y) {
    loops_->convolve_row(in, layer, &values[layer.weights], &values[layer.bias], slope, out, y);
  });
}

void PyramidPass::run_network(std::span<const float> values, TaskPool* pool) {
  run_layer(values, kFirstLayer, input_, first_, pool);
  run_layer(values, kDown1, first_, down_[1], pool);
  for (int l = 2; l <= kLast; ++l) {
    pooled_[l].resize(levels_[l].height, levels_[l].width, kPyramidChannels, pool);
    for_rows(pool, levels_[l].height, [&](int y) { pool_row(down_[l - 1], pooled_[l], y); });
    run_layer(values, kDownParts[l], pooled_[l], down_[l], pool);
  }
  run_layer(values, kHeadParts[kLast], down_[kLast], head_[kLast], pool);
  for (int l = kLast - 1; l >= 1; --l) {
    const Cells& coarse = l + 1 == kLast ? down_[kLast] : up_[l + 1];
    sum_[l].resize(levels_[l].height, levels_[l].width, kPyramidChannels, pool);
    for_rows(pool, levels_[l].height, [&](int y) { sum_row(down_[l], coarse, sum_[l], y); });
    run_layer(values, kUpParts[l], sum_[l], up_[l], pool);
    run_layer(values, kHeadParts[l], up_[l], head_[l], pool);
  }
}

const float* PyramidPass::coarsen_logit(int level, int y, int x) const {
  if (level > 0) return head_[level].at(y, x) + kCoarsenLogit;
  return head_[1].at(y / 2, x / 2) + kPixelCoarsenLogits + 2 * (y % 2) + x % 2;
}

float* PyramidPass::d_coarsen_logit(int level, int y, int x) {
  if (level > 0) return d_head_[level].at(y, x) + kCoarsenLogit;
  return d_head_[1].at(y / 2, x / 2) + kPixelCoarsenLogits + 2 * (y % 2) + x % 2;
}

// The colours of the level from those of the finer one.
void PyramidPass::coarsen(int l, TaskPool* pool) {
  const Level &fine = levels_[l - 1], &level = levels_[l];
  for_rows(pool, level.height, [&](int y) {
    for (int x = 0; x < level.width; ++x) {
      float e[kLanes] = {};
      for (int s = 0; s < kBlock; ++s) e[s] = *coarsen_logit(l - 1, 2 * y + s / 2, 2 * x + s % 2);
      const float most = std::max(std::max(e[0], e[1]), std::max(e[2], e[3]));
      for (int s = 0; s < kBlock; ++s) e[s] -= most;
      store(e, exp_lanes(load(e)));
      const float over = 1 / ((e[0] + e[1]) + (e[2] + e[3]));
      float light[kColour] = {};
      for (int s = 0; s < kBlock; ++s) {
        const int fy = 2 * y + s / 2, fx = 2 * x + s % 2;
        const float count = fine.counts.at(0, fy)[fx] = e[s] * over;
        for (int c = 0; c < kColour; ++c) light[c] += count * fine.colour.at(c, fy)[fx];
      }
      for (int c = 0; c < kColour; ++c) level.colour.at(c, y)[x] = light[c];
    }
    extend(level.colour, y);
  });
}

void PyramidPass::filter(std::span<const float> values, int l, bool learns, TaskPool* pool) {
  Level& level = levels_[l];
  if (learns) level.kernels.resize(level.height, level.width, kPyramidTaps);
  float scales[2 * kDistances];
  for (size_t k = 0; k < std::size(scales); ++k)
    scales[k] = std::exp(values[pyramid_scales() + static_cast<size_t>(l) * std::size(scales) + k]);
  // Two rows of cells, which share a row of the level above, by the same thread.
  for_rows(pool, (level.height + 1) / 2, [&](int pair) {
    Expanded coarse(level.width, kColour + kFeatures);
    std::vector<float> logits(static_cast<size_t>(coarse.pitch * kPyramidTaps));
    std::vector<float> head0(l == 0 ? static_cast<size_t>(level.width) * 2 * kCellLogits : 0);
    for (int y = 2 * pair; y < std::min(2 * pair + 2, level.height); ++y) {
      FilterRow row;
      row.y = y;
      row.colour = level.colour, row.features = level.features;
      row.pitch = coarse.pitch;
      if (l < kLast)
        for (int slot : {0, 1}) {
          const Level& next = levels_[l + 1];
          const int from = Expanded::nearest(y, slot, next.height);
          coarse.expand(next.result, from, slot, 0);
          coarse.expand(next.features, from, slot, kColour);
          row.coarse_colour[slot] = coarse.row[slot];
          row.coarse_features[slot] = coarse.row[slot] + kColour * coarse.pitch;
        }
      if (l == 0 && y % 2 == 0) {
        const PyramidLayer layer = pyramid_layer(kHead0);
        const CellGrid in{up_[1].at(pair, 0), up_[1].row, 1, up_[1].width, up_[1].channels};
        const CellGrid out{head0.data(), 0, 1, level.width / 2, layer.outputs};
        loops_->convolve_row(in, layer, &values[layer.weights], &values[layer.bias], 1, out, 0);
      }
      for (int x = 0; x < level.width; ++x) {
        const int pixel = x / 2 * kBlock + 2 * (y % 2) + x % 2;
        const float* from =
            l == 0 ? &head0[static_cast<size_t>(pixel * kCellLogits)] : head_[l].at(y, x);
        for (int t = 0; t < kPyramidTaps; ++t)
          logits[static_cast<size_t>(t * coarse.pitch + x)] = from[t];
      }
      row.logits = logits.data();
      row.scales = scales;
      row.out = level.result.at(0, y);
      row.kernels = learns ? level.kernels.at(0, y) : nullptr;
      loops_->filter_row(row);
      extend(level.result, y);
    }
  });
}

Image PyramidPass::forward(std::span<const float> values, const PyramidInput& input, TaskPool* pool,
                           bool learns) {
  QRAY_CHECK(values.size() == pyramid_size() && input.pictures.features.channels() == kFeatures);
  pack(input, pool);
  run_network(values, pool);
  for (int l = 1; l < kPyramidLevels; ++l) coarsen(l, pool);
  for (int l = kLast; l >= 0; --l) filter(values, l, learns, pool);
  Image out = Image::unset(width_, height_, kColour);
  for_rows(pool, height_, [&](int y) {
    for (int x = 0; x < width_; ++x)
      for (int c = 0; c < kColour; ++c) out.at(x, y, c) = levels_[0].result.at(c, y)[x];
  });
  return out;
}

Image PyramidPass::recover(std::span<const float> values, const PyramidInput& input,
                           TaskPool* pool) {
  Image picture = forward(values, input, pool, false);
  for_rows(pool, height_, [&](int y) {
    for (int x = 0; x < width_; ++x)
      for (int c = 0; c < kColour; ++c)
        picture.at(x, y, c) *= input.pictures.features.at(x, y, c) + kAlbedoFloor;
  });
  return picture;
}

// By d_result of the level: d_colour of it, d_result of the coarser one, and d_head.
void PyramidPass::back_filter(int l, std::span<const float> scales, std::span<double> d_scales) {
  Level& level = levels_[l];
  Expanded coarse(level.width, kColour + kFeatures), d_coarse(level.width, kColour);
  std::vector<float> d_logits(static_cast<size_t>(coarse.pitch * kPyramidTaps));
  for (int y = 0; y < level.height; ++y) {
    BackFilterRow back;
    FilterRow& row = back.forward;
    row.y = y;
    row.colour = level.colour, row.features = level.features;
    row.pitch = coarse.pitch;
    if (l < kLast)
      for (int slot : {0, 1}) {
        const Level& next = levels_[l + 1];
        const int from = Expanded::nearest(y, slot, next.height);
        coarse.expand(next.result, from, slot, 0);
        coarse.expand(next.features, from, slot, kColour);
        row.coarse_colour[slot] = coarse.row[slot];
        row.coarse_features[slot] = coarse.row[slot] + kColour * coarse.pitch;
        std::fill(d_coarse.memory[slot].begin(), d_coarse.memory[slot].end(), 0.0f);
        back.d_coarse_colour[slot] = d_coarse.row[slot];
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
                          Expanded::nearest(y, slot, levels_[l + 1].height), slot);
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

// d_out: by the layer's result; becomes that before its leaky unit. d_in is written, if wanted.
void PyramidPass::back_layer(std::span<const float> values, PyramidPart part, const Cells& in,
                             const Cells& out, Cells& d_out, Cells* d_in,
                             std::span<float> gradient) {
  const PyramidLayer layer = pyramid_layer(part);
  if (part < kHead5) back_leaky(d_out, out);
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
      d->resize(level.height, level.width, kColour);
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
    const Cells& unit = l < kLast ? up_[l] : down_[l];
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
      back_layer(values, kHead0, unit, head_[0], d_head_[0], &d_head_in, gradient);
      add(d_unit, d_head_in);
    }
    back_layer(values, kHeadParts[l], unit, head_[l], d_head_[l], &d_head_in, gradient);
    add(d_unit, d_head_in);
    if (l < kLast) back_layer(values, kUpParts[l], sum_[l], up_[l], d_up_[l], &d_sum_[l], gradient);
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
    back_layer(values, kDownParts[l], l == 1 ? first_ : pooled_[l], down_[l], d_down_[l],
               l == 1 ? &d_first_ : &d_pooled_[l], gradient);
  }
  back_layer(values, kFirstLayer, input_, first_, d_first_, nullptr, gradient);
}

}  // namespace qray
