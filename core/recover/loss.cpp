#include "core/recover/loss.h"

#include <cmath>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kLossScale = 10, kSmooth = 0.05f;

// A term, and its gradient.
struct Term {
  float loss, d;
};

Term charbonnier(float e) {
  const float root = std::sqrt(e * e + kSmooth * kSmooth);
  return {root - kSmooth, e / root};
}

}  // namespace

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
