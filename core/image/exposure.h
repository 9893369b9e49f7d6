// How bright a linear picture is shown: stops, each twice the light. Any thread.
#pragma once

#include "core/image/image.h"

namespace qray {

constexpr float kMaxExposure = 32;  // stops, either way

// Multiplies by 2^stops.
void expose(Image& image, float stops);
// The stops that bring the log-average luminance of what is not black to a middle grey of .18
// (Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images"); 0 of a black
// picture.
float auto_exposure(const Image& image);

}  // namespace qray
