// What training lowers. Any thread.
#pragma once

#include <span>
#include <vector>

#include "core/image/image.h"

namespace qray {

// (y - t)^2 / (mean(y)^2 + .02), the denominator taken as constant: its minimum is the mean of
// noisy targets (Lehtinen et al., "Noise2Noise", 2018). Terms above 20 count 20 and teach nothing.
// Mean over the colours [pixel][3] of y = result x albedo against the target; d_result: its
// gradient by `result`.
double relative_squared_loss(std::span<const float> result, std::span<const float> albedo,
                             std::span<const float> target, std::vector<float>& d_result);

// For targets with little noise: of the difference e of log(1 + 10 y) and log(1 + 10 t), in a
// picture of usual brightness, sqrt(e^2 + .05^2) - .05, and the same of the differences of e from
// each pixel to the next in its row and in its column, which keeps edges and finds blotches. Mean
// over pixels and channels of pictures of three channels, y = result x albedo.
double log_loss(const Image& result, const Image& albedo, const Image& target,
                std::vector<float>& d_result);

}  // namespace qray
