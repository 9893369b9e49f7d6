// LDR-FLIP: how much a viewer sees between two pictures that are flipped between (Andersson et al.
// 2020, "FLIP: A Difference Evaluator for Alternating Images"). Section and equation numbers in the
// .cpp are that paper's. Any thread.
#pragma once

#include "core/image/image.h"

namespace qray {

// The error per pixel in [0, 1]. Pictures of one size, 3 channels; linear, clamped to [0, 1].
Image flip_map(const Image& picture, const Image& reference, float pixels_per_degree = 67);

}  // namespace qray
