// What training lowers. Any thread.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace qray {

// For targets with little noise: of the difference e of log(1 + 10 y) and log(1 + 10 t), in a
// picture of usual brightness, sqrt(e^2 + .05^2) - .05, and the same of the differences of e from
// each pixel to the next in its row and in its column, which keeps edges and finds blotches. Mean
// over pixels and channels of pictures of three channels, y = result x albedo.
double log_loss(const Image& result, const Image& albedo, const Image& target,
                std::vector<float>& d_result);

}  // namespace qray
