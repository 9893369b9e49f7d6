// The loops of the pyramid, as many numbers at once as a register of the processor holds: of wider
// vectors GCC keeps sums in memory. Included by one file for each kind of processor, so all of it
// has internal linkage and uses nothing of the library.
#pragma once

#include "core/recover/lanes.h"
#include "core/recover/pyramid_rows.h"

namespace qray {
namespace {

// Cells, and inputs, whose sums stay in registers, beside two vectors of outputs.
#if defined(QRAY_LOOPS_OF_AVX512)
constexpr int kWidth = 16, kCellsAtOnce = 8, kGradientInputs = 8;
#else
constexpr int kWidth = 8, kCellsAtOnce = 6, kGradientInputs = 4;
#endif
constexpr int kWide = 2;
using Vec = float __attribute__((vector_size(4 * kWidth)));
using IntVec = int32_t __attribute__((vector_size(4 * kWidth)));

[[gnu::always_inline]] inline Vec load_vec(const float* p) {
  Vec v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
[[gnu::always_inline]] inline void store_vec(float* p, const Vec& v) {
  std::memcpy(p, &v, sizeof v);
}
[[gnu::always_inline]] inline Vec all(float v) { return v - Vec{}; }

// kCount cells of a row, kWidth x kGroups outputs.
template <int kCount, int kGroups>
[[gnu::always_inline]] inline void cells_run(const CellGrid& in, int y, int x,
                                             const PyramidLayer& layer, const float* weights,
                                             const float* bias, float slope, float* out) {
  Vec sum[kCount][kGroups];
  for (int k = 0; k < kCount; ++k)
    for (int g = 0; g < kGroups; ++g) sum[k][g] = bias ? load_vec(bias + g * kWidth) : Vec{};
  const int half = layer.side / 2;
  for (int ky = -half; ky <= half; ++ky)
    for (int kx = -half; kx <= half; ++kx) {
      const float* p = in.at(y + ky, x + kx);
      for (int i = 0; i < layer.inputs; ++i, weights += layer.outputs) {
        Vec w[kGroups];
        for (int g = 0; g < kGroups; ++g) w[g] = load_vec(weights + g * kWidth);
        for (int k = 0; k < kCount; ++k)
          for (int g = 0; g < kGroups; ++g) sum[k][g] += p[k * in.channels + i] * w[g];
      }
    }
  for (int k = 0; k < kCount; ++k)
    for (int g = 0; g < kGroups; ++g)
      store_vec(out + k * layer.outputs + g * kWidth,
                sum[k][g] < 0.0f ? sum[k][g] * slope : sum[k][g]);
}

template <int kGroups>
inline void convolve_groups(const CellGrid& in, const PyramidLayer& layer, const float* weights,
                            const float* bias, float slope, const CellGrid& out, int y) {
  for (int o = 0; o < layer.outputs; o += kGroups * kWidth) {
    const float* b = bias ? bias + o : nullptr;
    int x = 0;
    for (; x + kCellsAtOnce <= out.width; x += kCellsAtOnce)
      cells_run<kCellsAtOnce, kGroups>(in, y, x, layer, weights + o, b, slope, out.at(y, x) + o);
    for (; x < out.width; ++x)
      cells_run<1, kGroups>(in, y, x, layer, weights + o, b, slope, out.at(y, x) + o);
  }
}

void convolve_row(const CellGrid& in, const PyramidLayer& layer, const float* weights,
                  const float* bias, float slope, const CellGrid& out, int y) {
  if (layer.outputs % (kWide * kWidth) == 0)
    convolve_groups<kWide>(in, layer, weights, bias, slope, out, y);
  else
    convolve_groups<1>(in, layer, weights, bias, slope, out, y);
}

template <int kGroups>
inline void gradient_groups(const CellGrid& in, const PyramidLayer& layer, const CellGrid& d_out,
                            float* d_weights) {
  const int half = layer.side / 2;
  for (int tap = 0; tap < layer.side * layer.side; ++tap)
    for (int i = 0; i < layer.inputs; i += kGradientInputs)
      for (int o = 0; o < layer.outputs; o += kGroups * kWidth) {
        Vec sum[kGradientInputs][kGroups] = {};
        for (int y = 0; y < d_out.height; ++y) {
          const float* p = in.at(y + tap / layer.side - half, tap % layer.side - half) + i;
          const float* d = d_out.at(y, 0) + o;
          for (int x = 0; x < d_out.width; ++x, p += in.channels, d += d_out.channels) {
            Vec v[kGroups];
            for (int g = 0; g < kGroups; ++g) v[g] = load_vec(d + g * kWidth);
            for (int k = 0; k < kGradientInputs; ++k)
              for (int g = 0; g < kGroups; ++g) sum[k][g] += p[k] * v[g];
          }
        }
        float* to =
            d_weights + static_cast<std::ptrdiff_t>(tap * layer.inputs + i) * layer.outputs + o;
        for (int k = 0; k < kGradientInputs; ++k, to += layer.outputs)
          for (int g = 0; g < kGroups; ++g)
            store_vec(to + g * kWidth, load_vec(to + g * kWidth) + sum[k][g]);
      }
}

void add_weight_gradient(const CellGrid& in, const PyramidLayer& layer, const CellGrid& d_out,
                         float* d_weights, float* d_bias) {
  if (layer.outputs % (kWide * kWidth) == 0)
    gradient_groups<kWide>(in, layer, d_out, d_weights);
  else
    gradient_groups<1>(in, layer, d_out, d_weights);
  for (int y = 0; y < d_out.height; ++y)
    for (int x = 0; x < d_out.width; ++x)
      for (int o = 0; o < layer.outputs; ++o) d_bias[o] += d_out.at(y, x)[o];
}

// The features of kWidth cells, and what those of their taps differ by.
struct Centre {
  Vec at[kFeatures], inverse_depth;

  [[gnu::always_inline]] Centre(const CellPlanes& features, int y, int x) {
    for (int f = 0; f < kFeatures; ++f) at[f] = load_vec(features.at(f, y) + x);
    inverse_depth = 1.0f / (at[kFeatureDepth] + 0.01f);
  }
  // Of taps whose first feature is at `tap`, the others `pitch` apart.
  [[gnu::always_inline]] void distances(const float* tap, std::ptrdiff_t pitch,
                                        Vec (&out)[kDistances]) const {
    Vec normal{}, albedo{};
    for (int k = 0; k < 3; ++k) {
      const Vec n = at[kFeatureNormal + k] - load_vec(tap + (kFeatureNormal + k) * pitch);
      normal += n * n;
      const Vec a = at[k] - load_vec(tap + k * pitch);
      albedo += a * a;
    }
    Vec depth = (at[kFeatureDepth] - load_vec(tap + kFeatureDepth * pitch)) * inverse_depth;
    depth *= depth;
    const Vec kind = at[kFeatureKind] - load_vec(tap + kFeatureKind * pitch);
    out[0] = normal;
    out[1] = depth < kMaxDepthDistance ? depth : all(kMaxDepthDistance);
    out[2] = albedo;
    out[3] = kind * kind;
  }
};

// Where tap t of kWidth cells begins: of this level's planes, or of the coarser ones.
struct Tap {
  const float *colour, *features;
  std::ptrdiff_t colour_pitch, features_pitch;
  const float* scales;
};

[[gnu::always_inline]] inline Tap tap_of(const FilterRow& r, int x, int t) {
  if (t < kTaps) {
    int y = r.y + t / 3 - 1;
    y = y < 0 ? 0 : y >= r.colour.height ? r.colour.height - 1 : y;
    const int tx = x + t % 3 - 1;
    return {r.colour.at(0, y) + tx, r.features.at(0, y) + tx, r.colour.pitch, r.features.pitch,
            r.scales};
  }
  const int row = (t - kTaps) / 2, tx = x + 2 * ((t - kTaps) % 2) - 1;
  return {r.coarse_colour[row] + tx, r.coarse_features[row] + tx, r.pitch, r.pitch,
          r.scales + kDistances};
}

void filter_row(const FilterRow& r) {
  const int taps = r.coarse_colour[0] ? kPyramidTaps : kTaps;
  for (int x = 0; x < r.colour.width; x += kWidth) {
    const Centre centre(r.features, r.y, x);
    Vec kernel[kPyramidTaps], most = all(-1e30f);
    for (int t = 0; t < taps; ++t) {
      const Tap tap = tap_of(r, x, t);
      Vec d[kDistances];
      centre.distances(tap.features, tap.features_pitch, d);
      Vec v = load_vec(r.logits + t * r.pitch + x);
      for (int k = 0; k < kDistances; ++k) v -= tap.scales[k] * d[k];
      kernel[t] = v;
      most = v > most ? v : most;
    }
    Vec sum{}, out[kColour] = {};
    for (int t = 0; t < taps; ++t) {
      kernel[t] = exp_of<Vec, IntVec>(kernel[t] - most);
      sum += kernel[t];
    }
    const Vec inverse = 1.0f / sum;
    for (int t = 0; t < taps; ++t) {
      const Tap tap = tap_of(r, x, t);
      kernel[t] *= inverse;
      for (int c = 0; c < kColour; ++c)
        out[c] += kernel[t] * load_vec(tap.colour + c * tap.colour_pitch);
      if (r.kernels) store_vec(r.kernels + t * r.pitch + x, kernel[t]);
    }
    for (int c = 0; c < kColour; ++c) store_vec(r.out + c * r.pitch + x, out[c]);
  }
}

[[gnu::always_inline]] inline void add_to(float* to, const Vec& v) {
  store_vec(to, load_vec(to) + v);
}

void back_filter_row(const BackFilterRow& b) {
  const FilterRow& r = b.forward;
  const int taps = r.coarse_colour[0] ? kPyramidTaps : kTaps;
  Vec scales[2][kDistances] = {};
  for (int x = 0; x < r.colour.width; x += kWidth) {
    const Centre centre(r.features, r.y, x);
    Vec d_out[kColour], d_kernel[kPyramidTaps], mean{};
    for (int c = 0; c < kColour; ++c) {
      d_out[c] = load_vec(b.d_out + c * r.pitch + x);
      for (int k = r.colour.width - x; k < kWidth; ++k) d_out[c][k] = 0;
    }
    for (int t = 0; t < taps; ++t) {
      const Tap tap = tap_of(r, x, t);
      const Vec kernel = load_vec(r.kernels + t * r.pitch + x);
      d_kernel[t] = Vec{};
      for (int c = 0; c < kColour; ++c)
        d_kernel[t] += d_out[c] * load_vec(tap.colour + c * tap.colour_pitch);
      mean += kernel * d_kernel[t];
      // As tap_of(), of the gradients.
      if (t < kTaps) {
        int y = r.y + t / 3 - 1;
        y = y < 0 ? 0 : y >= r.colour.height ? r.colour.height - 1 : y;
        for (int c = 0; c < kColour; ++c)
          add_to(b.d_colour.at(c, y) + x + t % 3 - 1, kernel * d_out[c]);
      } else {
        float* to = b.d_coarse_colour[(t - kTaps) / 2] + x + 2 * ((t - kTaps) % 2) - 1;
        for (int c = 0; c < kColour; ++c) add_to(to + c * r.pitch, kernel * d_out[c]);
      }
    }
    for (int t = 0; t < taps; ++t) {
      const Tap tap = tap_of(r, x, t);
      const Vec d = load_vec(r.kernels + t * r.pitch + x) * (d_kernel[t] - mean);
      store_vec(b.d_logits + t * r.pitch + x, d);
      Vec distances[kDistances];
      centre.distances(tap.features, tap.features_pitch, distances);
      for (int k = 0; k < kDistances; ++k) scales[t < kTaps ? 0 : 1][k] -= d * distances[k];
    }
  }
  for (int g = 0; g < 2; ++g)
    for (int k = 0; k < kDistances; ++k)
      for (int lane = 0; lane < kWidth; ++lane)
        b.d_scales[g * kDistances + k] += static_cast<double>(scales[g][k][lane]);
}

constexpr PyramidLoops kPyramidLoops{convolve_row, add_weight_gradient, filter_row,
                                     back_filter_row};

}  // namespace
}  // namespace qray
