// The loops of FastRecovery, a row of blocks at a time, 16 blocks at once. Included by one file for
// each kind of processor, so all of it has internal linkage and uses nothing of the library.
// Planes have kBorder blocks on either side that copy the picture's edge, and room for 16 more on
// the right, which are worked on too, whatever is there.
#pragma once

#include "core/recover/infer_rows.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

#if defined(QRAY_LOOPS_OF_AVX512)
constexpr int kAtOnce = 8;  // sums that stay in registers
#else
constexpr int kAtOnce = 4;
#endif
constexpr int padded(int n) { return (n + kAtOnce - 1) / kAtOnce * kAtOnce; }

// Sums kAtOnce of n inputs' planes, weights [input][outputs].
struct Sums {
  Lanes v[kAtOnce];
};

// The columns beyond the edge of a row that was made, of the first `count` planes.
inline void extend(const InferRows& r, const Planes& planes, int y, int count) {
  for (int k = 0; k < count; ++k) {
    float* row = planes.at(k, y, 0);
    for (int b = 1; b <= kBorder; ++b) {
      row[-b] = row[0];
      row[r.width - 1 + b] = row[r.width - 1];
    }
  }
}

// The row that a tap reaches: pictures end in copies of their edge.
inline int reach(const InferRows& r, int y, int offset) {
  const int to = y + offset;
  return to < 0 ? 0 : to >= r.height ? r.height - 1 : to;
}

// Exchanges v[i][k] and v[k][i].
inline void transpose(Lanes (&v)[kLanes]) {
  for (int d = 1; d < kLanes; d *= 2) {
    IntLanes low, high;
    for (int k = 0; k < kLanes; ++k) {
      low[k] = k & d ? kLanes + k - d : k;
      high[k] = k & d ? kLanes + k : k + d;
    }
    for (int i = 0; i < kLanes; ++i) {
      if (i & d) continue;
      const Lanes a = v[i], b = v[i | d];
      v[i] = __builtin_shuffle(a, b, low);
      v[i | d] = __builtin_shuffle(a, b, high);
    }
  }
}

// The features of two pixels beside each other, kLanes numbers, for each block of a row of pixels.
inline void pack_features(const InferRows& r, int y, int half) {
  static_assert(2 * kFeatures == kLanes);
  const float* from =
      r.pixel_features + static_cast<ptrdiff_t>(2 * y + half) * r.width * 2 * kFeatures;
  for (int x = 0; x < r.width; x += kLanes) {
    Lanes v[kLanes];
    for (int b = 0; b < kLanes; ++b) {
      const int block = x + b < r.width ? x + b : r.width - 1;
      v[b] = load(from + static_cast<ptrdiff_t>(block) * kLanes);
    }
    transpose(v);
    for (int k = 0; k < kLanes; ++k) store(r.features.at(half * kLanes + k, y, x), v[k]);
  }
}

inline void layer1(const InferRows& r, int y) {
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
  extend(r, r.layer1, y, r.hidden);
}

void pack_row(const InferRows& r, int y) {
  for (int half : {0, 1}) pack_features(r, y, half);
  const ptrdiff_t first = static_cast<ptrdiff_t>(2 * y) * 2 * r.width;  // pixel of the row
  for (int c = 0; c < kColour; ++c) {
    float *known = r.known.at(c, y, 0), *colour = r.colour.at(c, y, 0);
    const float *albedo = r.features.at(c, y, 0), *light = r.pixel_colour + first * kColour + c;
    for (int x = 0; x < r.width; ++x) {
      known[x] = light[2 * kColour * x] / (albedo[x] + kAlbedoFloor);
      colour[x] = known[x] / (1 + known[x]);
    }
  }
  float* noise = r.noise.at(0, y, 0);
  for (int x = 0; x < r.width; ++x) noise[x] = r.pixel_noise[first + 2 * x];
  extend(r, r.features, y, kFeatures);  // taps reach known pixels alone
  extend(r, r.known, y, kColour);
  layer1(r, y);
}

inline void layer2(const InferRows& r, int y, int x) {
  for (int o = 0; o < r.hidden; o += kAtOnce) {
    Sums s;
    for (int k = 0; k < kAtOnce; ++k) s.v[k] = splat(r.bias2[o + k]);
    for (int t = 0; t < kTaps; ++t) {
      const float* w = r.weights2 + t * r.hidden * r.hidden + o;
      const float* in = r.layer1.at(0, reach(r, y, t / 3 - 1), x + t % 3 - 1);
      for (int i = 0; i < r.hidden; ++i, w += r.hidden, in += r.layer1.pitch) {
        const Lanes v = load(in);
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
    const int ty = reach(r, y, (t / 3 - 1) * dilation), tx = x + (t % 3 - 1) * dilation;
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
inline void apply(const InferRows& r, int y, int x, int dilation, const Lanes* kernel,
                  const Planes& from, const Planes& to) {
  for (int c = 0; c < kColour; ++c) {
    Lanes sum{};
    for (int t = 0; t < kTaps; ++t)
      sum += kernel[t] *
             load(from.at(c, reach(r, y, (t / 3 - 1) * dilation), x + (t % 3 - 1) * dilation));
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
        apply(r, y, x, kDilations[0], taps, r.known, r.filtered[0]);
      else
        for (int t = 0; t < kTaps; ++t) store(r.kernels[f].at(t, y, x), taps[t]);
    }
  }
  extend(r, r.filtered[0], y, kColour);
}

void later_filter_row(const InferRows& r, int y, int f) {
  for (int x = 0; x < r.width; x += kLanes) {
    Lanes taps[kTaps];
    for (int t = 0; t < kTaps; ++t) taps[t] = load(r.kernels[f].at(t, y, x));
    apply(r, y, x, kDilations[static_cast<size_t>(f)], taps, r.filtered[f - 1], r.filtered[f]);
  }
  extend(r, r.filtered[f], y, kColour);
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
                 load(r.filtered[kFilters - 1].at(c, reach(r, y, t / 3 - 1), x + t % 3 - 1));
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

constexpr InferLoops kLoops{pack_row, first_filter_row, later_filter_row, pixels_row};

}  // namespace
}  // namespace qray
