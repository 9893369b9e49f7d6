// What training lowers. Any thread.
#pragma once

#include <span>
#include <vector>

namespace qray {

enum class Loss {
  // (y - t)^2 / (mean(y)^2 + .02), the denominator taken as constant: its minimum is the mean of
  // noisy targets (Lehtinen et al., "Noise2Noise", 2018). Terms above 20 count 20 and teach
  // nothing.
  kRelativeSquared,
  kRootCharbonnier,  // |sqrt(y + .001) - sqrt(t + .001)|, smoothed: for clean targets
};

// Mean over the colours [pixel][3] of y = result x albedo against the target; d_result: its
// gradient by `result`.
double loss_of(Loss loss, std::span<const float> result, std::span<const float> albedo,
               std::span<const float> target, std::vector<float>& d_result);

}  // namespace qray
