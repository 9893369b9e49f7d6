#include "core/recover/loss.h"

#include <cmath>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kDarkest = 0.02f;  // of squared means
constexpr float kMostTerm = 20;
constexpr float kRootOffset = 1e-3f, kSmooth = 1e-6f;

// One colour's term, and its gradient by y.
struct Term {
  float loss, d_y;
};

Term relative_squared(float y, float t, float mean) {
  const float weight = 1 / (mean * mean + kDarkest), difference = y - t;
  const float loss = difference * difference * weight;
  if (loss > kMostTerm) return {kMostTerm, 0};
  return {loss, 2 * difference * weight};
}

Term root_charbonnier(float y, float t) {
  const float root = std::sqrt(y + kRootOffset);
  const float difference = root - std::sqrt(t + kRootOffset);
  const float loss = std::sqrt(difference * difference + kSmooth);
  return {loss, difference / loss / (2 * root)};
}

}  // namespace

double loss_of(Loss loss, std::span<const float> result, std::span<const float> albedo,
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
      const Term term = loss == Loss::kRelativeSquared ? relative_squared(y[c], target[i + c], mean)
                                                       : root_charbonnier(y[c], target[i + c]);
      sum += static_cast<double>(term.loss);
      d_result[i + c] = term.d_y * albedo[i + c] * share;
    }
  }
  return sum * static_cast<double>(share);
}

}  // namespace qray
