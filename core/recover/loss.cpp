#include "core/recover/loss.h"

#include <cmath>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kDarkest = 0.02f;  // of squared means
constexpr float kMostTerm = 20;
constexpr float kLossScale = 10, kSmooth = 0.05f;

// A term, and its gradient.
struct Term {
  float loss, d;
};

Term relative_squared(float y, float t, float mean) {
  const float weight = 1 / (mean * mean + kDarkest), difference = y - t;
  const float loss = difference * difference * weight;
  if (loss > kMostTerm) return {kMostTerm, 0};
  return {loss, 2 * difference * weight};
}

Term charbonnier(float e) {
  const float root = std::sqrt(e * e + kSmooth * kSmooth);
  return {root - kSmooth, e / root};
}

}  // namespace

double relative_squared_loss(std::span<const float> result, std::span<const float> albedo,
                             std::span<const float> target, std::vector<float>& d_result) {
  QRAY_CHECK(result.size() == albedo.size() && result.size() == target.size());
  d_result.resize(result.size());
  const float share = 1 / static_cast<float>(result.size());
  double sum = 0;
  for (size_t i = 0; i < result.size(); i += 3) {
    float y[3];
    for (size_t c = 0; c < 3; ++c) y[c] = result[i + c] * albedo[i + c];
    const float mean = (y[0] + y[1] + y[2]) / 3;
    for (size_t c = 0; c < 3; ++c) {
      const Term term = relative_squared(y[c], target[i + c], mean);
      sum += static_cast<double>(term.loss);
      d_result[i + c] = term.d * albedo[i + c] * share;
    }
  }
  return sum * static_cast<double>(share);
}

double log_loss(const Image& result, const Image& albedo, const Image& target,
                std::vector<float>& d_result) {
  const size_t size = result.data().size();
  QRAY_CHECK(result.channels() == 3 && albedo.data().size() == size &&
             target.data().size() == size);
  const size_t row = static_cast<size_t>(result.width()) * 3;
  std::vector<float> e(size);
  for (size_t i = 0; i < size; ++i)
    e[i] = std::log(1 + kLossScale * result.data()[i] * albedo.data()[i]) -
           std::log(1 + kLossScale * target.data()[i]);
  d_result.assign(size, 0);
  double sum = 0;
  const auto add = [&](size_t from, size_t to) {
    const Term term = charbonnier(e[to] - e[from]);
    sum += static_cast<double>(term.loss);
    d_result[to] += term.d;
    d_result[from] -= term.d;
  };
  for (size_t i = 0; i < size; ++i) {
    const Term term = charbonnier(e[i]);
    sum += static_cast<double>(term.loss);
    d_result[i] += term.d;
    if (i % row >= 3) add(i - 3, i);
    if (i >= row) add(i - row, i);
  }
  const float share = 1 / static_cast<float>(size);
  for (size_t i = 0; i < size; ++i) {
    const float a = albedo.data()[i];
    d_result[i] *= share * kLossScale * a / (1 + kLossScale * result.data()[i] * a);
  }
  return sum * static_cast<double>(share);
}

}  // namespace qray
