#include "core/recover/pyramid_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

// Of colours as the network sees them: nearly linear up to a tenth of the mean.
constexpr float kLogScale = 10, kLogShare = 0.3f;
constexpr float kLeastLight = 1e-3f;
constexpr float kUnknown = std::numeric_limits<float>::infinity();

using Four = float __attribute__((vector_size(16)));
using FourInts = int32_t __attribute__((vector_size(16)));

// A row of planes goes on beyond its edges.
void extend(const CellPlanes& planes, int y) {
  for (int k = 0; k < planes.count; ++k) extend_row(planes.at(k, y), planes.width);
}

// Of 4 cells each their means.
void pool_row(const CellGrid& in, int y, float* out) {
  for (int x = 0; x < in.width / 2; ++x, out += kPyramidChannels) {
    const float *a = in.at(2 * y, 2 * x), *b = in.at(2 * y, 2 * x + 1),
                *c = in.at(2 * y + 1, 2 * x), *d = in.at(2 * y + 1, 2 * x + 1);
    for (int k = 0; k < kPyramidChannels; ++k) out[k] = 0.25f * ((a[k] + b[k]) + (c[k] + d[k]));
  }
}

void sum_row(const CellGrid& fine, const CellGrid& coarse, int y, float* out) {
  for (int x = 0; x < fine.width; ++x, out += kPyramidChannels) {
    const float *a = fine.at(y, x), *b = coarse.at(y / 2, x / 2);
    for (int k = 0; k < kPyramidChannels; ++k) out[k] = a[k] + b[k];
  }
}

// A pixel of a picture that goes on beyond its edges.
struct Pixel {
  int x, y;
  const float* features;
  Four light;  // colour over albedo; the last number is no colour

  Pixel(const RecoveryInput& from, int at_x, int at_y)
      : x(std::min(at_x, from.colour.width() - 1)), y(std::min(at_y, from.colour.height() - 1)) {
    const size_t i =
        static_cast<size_t>(y) * static_cast<size_t>(from.colour.width()) + static_cast<size_t>(x);
    features = &from.features.data()[i * kFeatures];
    const float* colour = &from.colour.data()[i * kColour];
    light = Four{colour[0], colour[1], colour[2], 0} /
            (Four{features[0], features[1], features[2], 0} + kAlbedoFloor);
  }
};

// So many of the logits that a head makes, from one on: a layer of its own.
struct SomeLogits {
  PyramidLayer layer;
  std::vector<float> values;

  SomeLogits(std::span<const float> all, PyramidPart part, int first, int outputs)
      : layer{1, kPyramidChannels, outputs, 0, static_cast<size_t>(kPyramidChannels * outputs)} {
    const PyramidLayer head = pyramid_layer(part);
    for (int row = 0; row <= kPyramidChannels; ++row) {  // the last one's are the biases
      const float* from = &all[head.weights + static_cast<size_t>(row * head.outputs + first)];
      values.insert(values.end(), from, from + outputs);
    }
  }
};

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

void PyramidPass::pack(const Run& run) {
  const RecoveryInput& pictures = run.input.pictures;
  const int width = pictures.colour.width(), height = pictures.colour.height();
  width_ = width, height_ = height;
  const auto whole = [](int n) { return (n + kPyramidSide - 1) / kPyramidSide * kPyramidSide; };
  for (int l = 0; l < kPyramidLevels; ++l) {
    Level& level = levels_[l];
    level.height = whole(height) >> l, level.width = whole(width) >> l;
    level.counts.resize_unset(level.height, level.width, 1);
    if (l == 0 && !run.learns) continue;
    level.colour.resize_unset(level.height, level.width, kColour);
    level.features.resize_unset(level.height, level.width, kFeatures);
    level.result.resize_unset(level.height, level.width, kColour);
  }
  for (int l = 1; l < kPyramidLevels; ++l)
    for_rows(run.pool, levels_[l].height, [&](int y) {
      const CellPlanes &from = levels_[l - 1].features, &to = levels_[l].features;
      for (int x = 0; l == 1 && x < to.width; ++x) {
        const float* f[kBlock];
        for (int s = 0; s < kBlock; ++s)
          f[s] = Pixel(pictures, 2 * x + s % 2, 2 * y + s / 2).features;
        for (int k = 0; k < kFeatures; ++k)
          to.at(k, y)[x] = 0.25f * ((f[0][k] + f[1][k]) + (f[2][k] + f[3][k]));
      }
      for (int k = 0; l > 1 && k < kFeatures; ++k) {
        const float *a = from.at(k, 2 * y), *b = from.at(k, 2 * y + 1);
        float* out = to.at(k, y);
        for (int x = 0; x < to.width; ++x)
          out[x] = 0.25f * ((a[2 * x] + a[2 * x + 1]) + (b[2 * x] + b[2 * x + 1]));
      }
      extend(to, y);
    });
}

// A row of the picture becomes that of planes.
void PyramidPass::unpack(const RecoveryInput& pictures, int y, const CellPlanes& colour,
                         const CellPlanes& features, int to) const {
  for (int x = 0; x < colour.width; ++x) {
    const Pixel pixel(pictures, x, y);
    for (int c = 0; c < kColour; ++c) colour.at(c, to)[x] = pixel.light[c];
    for (int k = 0; k < kFeatures; ++k) features.at(k, to)[x] = pixel.features[k];
  }
  extend(colour, to);
  extend(features, to);
}

// What the network sees of a row of blocks.
void PyramidPass::pack_inputs(const Run& run, int row, float* out) const {
  const RecoveryInput& pictures = run.input.pictures;
  const bool shows = !pictures.shown.empty(), knows_own = !pictures.own_error.empty();
  for (int x = 0; x < levels_[0].width; x += 2)
    for (int s = 0; s < kBlock; ++s, out += kPixelInputs) {
      const Pixel pixel(pictures, x + s % 2, 2 * row + s / 2);
      const Four logarithm =
          log_of<Four, FourInts>(1 + kLogScale * pixel.light * run.input.exposure);
      for (int c = 0; c < kColour; ++c) out[c] = kLogShare * logarithm[c];
      out[kPixelNoise] = pictures.noise.at(pixel.x, pixel.y, 0);
      const float own = knows_own ? pictures.own_error.at(pixel.x, pixel.y, 0) : kUnknown;
      const float light = luminance(pictures.colour.rgb(pixel.x, pixel.y)) + kLeastLight;
      out[kPixelOwnNoise] = std::isfinite(own) ? own / (own + light) : 1;
      const float shown = shows ? luminance(pictures.shown.rgb(pixel.x, pixel.y)) : 0;
      out[kPixelShown] = shown / (1 + shown);
      std::copy_n(pixel.features, kFeatures, out + kPixelFeatures);
    }
}

// A row of a layer that looks at no neighbours.
void PyramidPass::run_row(std::span<const float> values, const PyramidLayer& layer, float slope,
                          float* in, int width, float* out) const {
  const CellGrid from{in, 0, 1, width, layer.inputs}, to{out, 0, 1, width, layer.outputs};
  loops_->convolve_row(from, layer, &values[layer.weights], &values[layer.bias], slope, to, 0);
}

// out: of what make(y, row, worker) writes row by row. All of that is kept where it learns. Else
// each worker has a band of it, with a row on each side, in memory that stays near the processor.
template <typename MakeRow>
void PyramidPass::run_layer(const Run& run, PyramidPart part, int l, Cells& kept, Cells& out,
                            const MakeRow& make) {
  const PyramidLayer layer = pyramid_layer(part);
  const int height = levels_[l].height, width = levels_[l].width;
  out.resize_unset(height, width, layer.outputs);
  const int band = run.learns ? height : std::max(4, 32 >> l);
  for_bands(run.pool, height, band, [&](int begin, int end, int w) {
    const int rows = end - begin;
    Cells& in = run.learns ? kept : scratch_[static_cast<size_t>(w)].band;
    in.resize_unset(rows, width, layer.inputs);
    for (int y = -1; y <= rows; ++y) {
      std::fill(in.at(y, -1), in.at(y, 0), 0.0f);
      if (begin + y >= 0 && begin + y < height)
        make(begin + y, in.at(y, 0), w);
      else
        std::fill(in.at(y, 0), in.at(y, width), 0.0f);
      std::fill(in.at(y, width), in.at(y, width + 1), 0.0f);
    }
    const CellGrid to{out.at(begin, 0), out.row, rows, width, layer.outputs};
    for (int y = 0; y < rows; ++y) {
      loops_->convolve_row(in, layer, &run.values[layer.weights], &run.values[layer.bias], kSlope,
                           to, y);
      if (part > kDown5) keep_coarsen_logits(run, l, begin + y, w);
    }
  });
}

void PyramidPass::run_network(const Run& run) {
  const int width = levels_[1].width;
  if (run.learns) input_.resize_unset(levels_[1].height, width, kPyramidInputs);
  run_layer(run, kDown1, 1, first_, down_[1], [&](int y, float* out, int worker) {
    std::vector<float>& row = scratch_[static_cast<size_t>(worker)].inputs;
    row.resize(static_cast<size_t>(width * kPyramidInputs));
    float* in = run.learns ? input_.at(y, 0) : row.data();
    pack_inputs(run, y, in);
    run_row(run.values, pyramid_layer(kFirstLayer), kSlope, in, width, out);
  });
  for (int l = 2; l <= kLast; ++l)
    run_layer(run, kDownParts[l], l, pooled_[l], down_[l],
              [&](int y, float* out, int) { pool_row(down_[l - 1], y, out); });
  for (int l = kLast - 1; l >= 1; --l)
    run_layer(run, kUpParts[l], l, sum_[l], up_[l],
              [&](int y, float* out, int) { sum_row(down_[l], unit_of(l + 1), y, out); });
}

const PyramidCells& PyramidPass::unit_of(int level) const {
  return level < kLast ? up_[level] : down_[kLast];
}

// By which the row's cells will count in the coarser level, and those of level 1 their pixels.
void PyramidPass::keep_coarsen_logits(const Run& run, int l, int y, int worker) {
  const PyramidLayer head = pyramid_layer(kHeadParts[l]);
  std::vector<float>& logits = scratch_[static_cast<size_t>(worker)].logits;
  logits.resize(static_cast<size_t>(levels_[l].width * head.outputs));
  run_row(run.values, head, 1, up_[l].at(y, 0), levels_[l].width, logits.data());
  const float* from = logits.data();
  for (int x = 0; x < levels_[l].width; ++x, from += head.outputs) {
    levels_[l].counts.at(0, y)[x] = from[kCoarsenLogit];
    for (int s = 0; l == 1 && s < kBlock; ++s)
      levels_[0].counts.at(0, 2 * y + s / 2)[2 * x + s % 2] = from[kPixelCoarsenLogits + s];
  }
}

// The colours of the level from those of the finer one, whose logits become counts.
void PyramidPass::coarsen(const Run& run, int l) {
  const Level &fine = levels_[l - 1], &level = levels_[l];
  for_rows(run.pool, level.height, [&](int y) {
    for (int x = 0; x < level.width; ++x) {
      float e[kLanes] = {};
      for (int s = 0; s < kBlock; ++s) e[s] = fine.counts.at(0, 2 * y + s / 2)[2 * x + s % 2];
      const float most = std::max(std::max(e[0], e[1]), std::max(e[2], e[3]));
      for (int s = 0; s < kBlock; ++s) e[s] -= most;
      store(e, exp_lanes(load(e)));
      const float over = 1 / ((e[0] + e[1]) + (e[2] + e[3]));
      Four light{};
      for (int s = 0; s < kBlock; ++s) {
        const int fy = 2 * y + s / 2, fx = 2 * x + s % 2;
        const float count = fine.counts.at(0, fy)[fx] = e[s] * over;
        light += count * (l > 1 ? Four{fine.colour.at(0, fy)[fx], fine.colour.at(1, fy)[fx],
                                       fine.colour.at(2, fy)[fx]}
                                : Pixel(run.input.pictures, fx, fy).light);
      }
      for (int c = 0; c < kColour; ++c) level.colour.at(c, y)[x] = light[c];
    }
    extend(level.colour, y);
  });
}

// What a row of cells to be filtered has of its level and of the coarser one.
FilterRow PyramidPass::filter_row(int l, int y, ExpandedRows& coarse) const {
  FilterRow row;
  row.y = y;
  row.colour = levels_[l].colour, row.features = levels_[l].features;
  row.pitch = coarse.pitch;
  for (int i = 0; l < kLast && i < 2; ++i) {
    const Level& next = levels_[l + 1];
    const int from = ExpandedRows::nearest(y, i, next.height), slot = from % 2;
    if (std::exchange(coarse.held[slot], from) != from) {
      coarse.expand(next.result, from, slot, 0);
      coarse.expand(next.features, from, slot, kColour);
    }
    row.coarse_colour[i] = coarse.row[slot];
    row.coarse_features[i] = coarse.row[slot] + kColour * coarse.pitch;
  }
  return row;
}

// Of level 0 the results go to the picture, and what they are made of are planes of a band only.
void PyramidPass::filter(const Run& run, int l, Image& picture) {
  Level& level = levels_[l];
  if (run.learns) level.kernels.resize_unset(level.height, level.width, kPyramidTaps);
  float scales[2 * kDistances];
  for (size_t k = 0; k < std::size(scales); ++k)
    scales[k] =
        std::exp(run.values[pyramid_scales() + static_cast<size_t>(l) * std::size(scales) + k]);
  const Cells& in = unit_of(std::max(l, 1));
  // The logits of a row of cells, or of one of both rows of pixels.
  const int outputs = l > 0 ? kCellLogits : 2 * kCellLogits;
  const SomeLogits heads[2] = {{run.values, kHeadParts[l], 0, outputs},
                               {run.values, kHeadParts[l], l > 0 ? 0 : outputs, outputs}};
  const int band = run.learns ? level.height : std::max(2, 16 >> l);
  for_bands(run.pool, level.height, band, [&](int begin, int end, int worker) {
    Scratch& scratch = scratch_[static_cast<size_t>(worker)];
    scratch.coarse.resize(level.width, kColour + kFeatures);
    const std::ptrdiff_t pitch = scratch.coarse.pitch;
    scratch.planes.resize(static_cast<size_t>(pitch * kPyramidTaps));
    scratch.logits.resize(static_cast<size_t>(level.width * kCellLogits));
    scratch.result.resize(static_cast<size_t>(pitch * kColour));
    Plane& colour = l > 0 || run.learns ? level.colour : scratch.colour;
    Plane& features = l > 0 || run.learns ? level.features : scratch.features;
    const int top = l > 0 ? 0 : std::max(begin - 1, 0);
    if (l == 0) {
      const int bottom = std::min(end + 1, level.height);
      colour.resize_unset(bottom - top, level.width, kColour);
      features.resize_unset(bottom - top, level.width, kFeatures);
      for (int y = top; y < bottom; ++y) unpack(run.input.pictures, y, colour, features, y - top);
    }
    for (int y = begin; y < end; ++y) {
      FilterRow row = filter_row(l, y, scratch.coarse);
      row.y = y - top, row.colour = colour, row.features = features;
      const SomeLogits& head = heads[y % 2];
      run_row(head.values, head.layer, 1, in.at(l > 0 ? y : y / 2, 0), in.width,
              scratch.logits.data());
      for (int x = 0; x < level.width; ++x)
        for (int t = 0; t < kPyramidTaps; ++t)
          scratch.planes[t * pitch + x] = scratch.logits[x * kCellLogits + t];
      row.logits = scratch.planes.data();
      row.scales = scales;
      row.out = l > 0 ? level.result.at(0, y) : scratch.result.data();
      row.kernels = run.learns ? level.kernels.at(0, y) : nullptr;
      loops_->filter_row(row);
      if (l > 0)
        extend(level.result, y);
      else if (y < height_)
        for (int x = 0; x < width_; ++x)
          for (int c = 0; c < kColour; ++c)
            picture.at(x, y, c) =
                row.out[c * pitch + x] *
                (run.times_albedo ? run.input.pictures.features.at(x, y, c) + kAlbedoFloor : 1);
    }
  });
}

Image PyramidPass::run(const Run& run) {
  QRAY_CHECK(run.values.size() == pyramid_size() &&
             run.input.pictures.features.channels() == kFeatures);
  scratch_.resize(static_cast<size_t>(run.pool ? run.pool->threads() : 1));
  pack(run);
  run_network(run);
  for (int l = 1; l < kPyramidLevels; ++l) coarsen(run, l);
  Image picture = Image::unset(width_, height_, kColour);
  for (int l = kLast; l >= 0; --l) filter(run, l, picture);
  return picture;
}

Image PyramidPass::forward(std::span<const float> values, const PyramidInput& input, TaskPool* pool,
                           bool learns) {
  return run({values, input, pool, learns, false});
}

Image PyramidPass::recover(std::span<const float> values, const PyramidInput& input,
                           TaskPool* pool) {
  return run({values, input, pool, false, true});
}

}  // namespace qray
