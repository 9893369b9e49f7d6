// The loops of FastRecovery, a row of blocks at a time, 16 blocks at once. Included by one file for
// each kind of processor, so all of it has internal linkage and uses nothing of the library.
// Planes have a border of kBorder blocks that copies the picture's edge, and room for 16 more on
// the right.
#pragma once

#include "core/recover/infer_rows.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

#if defined(__AVX512F__)
constexpr int kAtOnce = 8;  // sums that stay in registers
#else
constexpr int kAtOnce = 4;
#endif
constexpr int padded(int n) { return (n + kAtOnce - 1) / kAtOnce * kAtOnce; }

// Sums kAtOnce of n inputs' planes, weights [input][outputs].
struct Sums {
  Lanes v[kAtOnce];
};

// The columns beyond the edge of a row that was made.
inline void extend(const InferRows& r, const Planes& planes, int y) {
  for (int k = 0; k < planes.count; ++k) {
    float* row = planes.at(k, y, 0);
    for (int b = 1; b <= kBorder; ++b) {
      row[-b] = row[0];
      row[r.width - 1 + b] = row[r.width - 1];
    }
  }
}

void layer1_row(const InferRows& r, int y) {
  for (int x = 0; x < r.width; x += kLanes) {
    const float* in[kInputs];
    for (int c = 0; c < kColour; ++c) in[c] = r.colour.at(c, y, x);
    in[kInputNoise] = r.noise.at(0, y, x);
    for (int f = 0; f < kBlock * kFeatures; ++f) in[kInputFeatures + f] = r.features.at(f, y, x);
    for (int o = 0; o < r.hidden; o += kAtOnce) {
      Sums s;
      for (int k = 0; k < kAtOnce; ++k) s.v[k] = splat(r.bias1[o + k]);
      for (int i = 0; i < kInputs; ++i) {
        const Lanes v = load(in[i]);
        for (int k = 0; k < kAtOnce; ++k) s.v[k] += r.weights1[i * r.hidden + o + k] * v;
      }
      for (int k = 0; k < kAtOnce; ++k) store(r.layer1.at(o + k, y, x), leaky(s.v[k], kSlope));
    }
  }
  extend(r, r.layer1, y);
}

inline void layer2(const InferRows& r, int y, int x) {
  for (int o = 0; o < r.hidden; o += kAtOnce) {
    Sums s;
    for (int k = 0; k < kAtOnce; ++k) s.v[k] = splat(r.bias2[o + k]);
    for (int t = 0; t < kTaps; ++t) {
      const float* w = r.weights2 + t * r.hidden * r.hidden + o;
      for (int i = 0; i < r.hidden; ++i, w += r.hidden) {
        const Lanes v = load(r.layer1.at(i, y + t / 3 - 1, x + t % 3 - 1));
        for (int k = 0; k < kAtOnce; ++k) s.v[k] += w[k] * v;
      }
    }
    for (int k = 0; k < kAtOnce; ++k) store(r.layer2.at(o + k, y, x), leaky(s.v[k], kSlope));
  }
}

// Logits first .. first + n of 16 blocks.
inline void logits(const InferRows& r, int y, int x, int first, int n, float* out) {
  for (int o = 0; o < n; o += kAtOnce) {  // those over n are of the next, or padding
    Sums s;
    for (int k = 0; k < kAtOnce; ++k) s.v[k] = splat(r.bias3[first + o + k]);
    for (int i = 0; i < r.hidden; ++i) {
      const Lanes v = load(r.layer2.at(i, y, x));
      const float* w = r.weights3 + i * kLogits + first + o;
      for (int k = 0; k < kAtOnce; ++k) s.v[k] += w[k] * v;
    }
    for (int k = 0; k < kAtOnce; ++k) store(out + (o + k) * kLanes, s.v[k]);
  }
}

// Less the scaled distances between the features of `pixel` of the blocks and the known pixels that
// the taps reach.
inline void subtract_distances(const InferRows& r, int y, int x, int pixel, int dilation,
                               const float* scales, float* logits) {
  Lanes at[kFeatures];
  for (int f = 0; f < kFeatures; ++f) at[f] = load(r.features.at(pixel * kFeatures + f, y, x));
  const Lanes inverse_depth = 1.0f / (at[kFeatureDepth] + 0.01f);
  for (int t = 0; t < kTaps; ++t) {
    const int ty = y + (t / 3 - 1) * dilation, tx = x + (t % 3 - 1) * dilation;
    Lanes normal{}, albedo{};
    for (int k = 0; k < 3; ++k) {
      const Lanes n = at[kFeatureNormal + k] - load(r.features.at(kFeatureNormal + k, ty, tx));
      normal += n * n;
      const Lanes a = at[k] - load(r.features.at(k, ty, tx));
      albedo += a * a;
    }
    Lanes depth = (at[kFeatureDepth] - load(r.features.at(kFeatureDepth, ty, tx))) * inverse_depth;
    depth *= depth;
    depth = depth < kMaxDepthDistance ? depth : splat(kMaxDepthDistance);
    const Lanes kind = at[kFeatureKind] - load(r.features.at(kFeatureKind, ty, tx));
    store(logits + t * kLanes,
          load(logits + t * kLanes) - (scales[0] * normal + scales[1] * depth + scales[2] * albedo +
                                       scales[3] * kind * kind));
  }
}

inline void softmax(float* logits, int n) {
  Lanes most = load(logits), sum{};
  for (int t = 1; t < n; ++t) {
    const Lanes v = load(logits + t * kLanes);
    most = v > most ? v : most;
  }
  for (int t = 0; t < n; ++t) {
    const Lanes e = exp_lanes(load(logits + t * kLanes) - most);
    sum += e;
    store(logits + t * kLanes, e);
  }
  const Lanes inverse = 1.0f / sum;
  for (int t = 0; t < n; ++t) store(logits + t * kLanes, load(logits + t * kLanes) * inverse);
}

// The kernel of 16 blocks over what lies `dilation` apart in 3 planes.
inline void apply(int y, int x, int dilation, const Lanes* kernel, const Planes& from,
                  const Planes& to) {
  for (int c = 0; c < kColour; ++c) {
    Lanes sum{};
    for (int t = 0; t < kTaps; ++t)
      sum += kernel[t] * load(from.at(c, y + (t / 3 - 1) * dilation, x + (t % 3 - 1) * dilation));
    store(to.at(c, y, x), sum);
  }
}

// Layer 2, the filters' kernels, and the first filter.
void first_filter_row(const InferRows& r, int y) {
  alignas(64) float kernels[padded(kUpLogits) * kLanes];
  for (int x = 0; x < r.width; x += kLanes) {
    layer2(r, y, x);
    logits(r, y, x, 0, kUpLogits, kernels);
    for (int f = 0; f < kFilters; ++f) {
      float* kernel = kernels + f * kTaps * kLanes;
      subtract_distances(r, y, x, 0, kDilations[static_cast<size_t>(f)], r.scales + f * kDistances,
                         kernel);
      softmax(kernel, kTaps);
      Lanes taps[kTaps];
      for (int t = 0; t < kTaps; ++t) taps[t] = load(kernel + t * kLanes);
      if (f == 0)
        apply(y, x, kDilations[0], taps, r.known, r.filtered[0]);
      else
        for (int t = 0; t < kTaps; ++t) store(r.kernels[f].at(t, y, x), taps[t]);
    }
  }
  extend(r, r.filtered[0], y);
}

void later_filter_row(const InferRows& r, int y, int f) {
  for (int x = 0; x < r.width; x += kLanes) {
    Lanes taps[kTaps];
    for (int t = 0; t < kTaps; ++t) taps[t] = load(r.kernels[f].at(t, y, x));
    apply(y, x, kDilations[static_cast<size_t>(f)], taps, r.filtered[f - 1], r.filtered[f]);
  }
  extend(r, r.filtered[f], y);
}

// The four pixels of each block.
void pixels_row(const InferRows& r, int y) {
  alignas(64) float kernels[padded(kBlock * kUpTaps) * kLanes], colour[3][kLanes];
  for (int x = 0; x < r.width; x += kLanes) {
    logits(r, y, x, kUpLogits, kBlock * kUpTaps, kernels);
    for (int s = 0; s < kBlock; ++s) {
      float* kernel = kernels + s * kUpTaps * kLanes;
      subtract_distances(r, y, x, s, 1, r.scales + kFilters * kDistances, kernel);
      softmax(kernel, kUpTaps);
      for (int c = 0; c < 3; ++c) {
        Lanes sum = load(kernel + kTaps * kLanes) * load(r.known.at(c, y, x));
        for (int t = 0; t < kTaps; ++t)
          sum += load(kernel + t * kLanes) *
                 load(r.filtered[kFilters - 1].at(c, y + t / 3 - 1, x + t % 3 - 1));
        store(colour[c], sum * (load(r.features.at(s * kFeatures + c, y, x)) + kAlbedoFloor));
      }
      const int n = x + kLanes <= r.width ? kLanes : r.width - x;
      float* out =
          r.out + (static_cast<ptrdiff_t>(2 * y + s / 2) * 2 * r.width + 2 * x + s % 2) * 3;
      for (int b = 0; b < n; ++b, out += 6)
        for (int c = 0; c < 3; ++c) out[c] = colour[c][b];
    }
  }
}

constexpr InferLoops kLoops{layer1_row, first_filter_row, later_filter_row, pixels_row};

}  // namespace
}  // namespace qray
