#include "core/recover/convolve.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/recover/lanes.h"

namespace qray {
namespace {

constexpr int kPixels = 6;  // at once: accumulators stay in AVX2's registers
constexpr int kInputsAtOnce = 4;

// kCount pixels from `in`, 16 outputs.
template <int kCount>
void convolve_run(const float* in, size_t row, int inputs, int side, const float* weights,
                  int outputs, const float* bias, float slope, float* out) {
  Lanes sum[kCount];
  for (Lanes& s : sum) s = bias ? load(bias) : Lanes{};
  for (int ky = 0; ky < side; ++ky)
    for (int kx = 0; kx < side; ++kx) {
      const float* p = in + static_cast<size_t>(ky) * row + static_cast<size_t>(kx * inputs);
      for (int i = 0; i < inputs; ++i, weights += outputs) {
        const Lanes w = load(weights);
        for (int k = 0; k < kCount; ++k) sum[k] += p[k * inputs + i] * w;
      }
    }
  for (int k = 0; k < kCount; ++k) store(out + k * outputs, leaky(sum[k], slope));
}

}  // namespace

void convolve(const Grid& in, int side, const float* weights, const float* bias, float slope,
              int outputs, Grid& out) {
  QRAY_CHECK(outputs % kLanes == 0 && in.height >= side && in.width >= side);
  out.resize(in.height - side + 1, in.width - side + 1, outputs);
  const size_t row = static_cast<size_t>(in.width) * static_cast<size_t>(in.channels);
  for (int y = 0; y < out.height; ++y)
    for (int o = 0; o < outputs; o += kLanes) {
      const float* b = bias ? bias + o : nullptr;
      int x = 0;
      for (; x + kPixels <= out.width; x += kPixels)
        convolve_run<kPixels>(in.at(y, x), row, in.channels, side, weights + o, outputs, b, slope,
                              out.at(y, x) + o);
      for (; x < out.width; ++x)
        convolve_run<1>(in.at(y, x), row, in.channels, side, weights + o, outputs, b, slope,
                        out.at(y, x) + o);
    }
}

void add_weight_gradient(const Grid& in, int side, const Grid& d_out, float* d_weights,
                         float* d_bias) {
  const int inputs = in.channels, outputs = d_out.channels;
  QRAY_CHECK(inputs % kInputsAtOnce == 0 && outputs % kLanes == 0);
  for (int tap = 0; tap < side * side; ++tap)
    for (int i = 0; i < inputs; i += kInputsAtOnce)
      for (int o = 0; o < outputs; o += kLanes) {
        Lanes sum[kInputsAtOnce] = {};
        for (int y = 0; y < d_out.height; ++y) {
          const float* p = in.at(y + tap / side, tap % side) + i;
          const float* d = d_out.at(y, 0) + o;
          for (int x = 0; x < d_out.width; ++x, p += inputs, d += outputs) {
            const Lanes v = load(d);
            for (int k = 0; k < kInputsAtOnce; ++k) sum[k] += p[k] * v;
          }
        }
        float* to =
            d_weights + static_cast<size_t>(tap * inputs + i) * static_cast<size_t>(outputs) + o;
        for (int k = 0; k < kInputsAtOnce; ++k, to += outputs) store(to, load(to) + sum[k]);
      }
  for (size_t p = 0; p < d_out.data.size(); p += static_cast<size_t>(outputs))
    for (int o = 0; o < outputs; ++o) d_bias[o] += d_out.data[p + static_cast<size_t>(o)];
}

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

}  // namespace qray
