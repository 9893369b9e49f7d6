// Pictures of where one picture differs from another, on scales that are the same for all. Pictures
// of one size, 3 channels. Any thread.
#pragma once

#include <string_view>

#include "core/image/image.h"

namespace qray {

// The relative squared error of each pixel, mean over channels of (x-r)^2/(r^2+0.01), viridis,
// logarithmic. What lies outside of the scale has the colour of its end, here and below.
Image error_map(const Image& picture, const Image& reference);
constexpr float kErrorMapLow = 1e-4f, kErrorMapHigh = 1;
constexpr std::string_view kErrorMapScale = "0.0001 (dark) to 1 (bright), logarithmic";

// By how much each pixel's luminance is above (red) or below (blue) the other's, over the mean
// luminance of both: diverging, white where they are equal.
Image signed_map(const Image& picture, const Image& other);
constexpr float kSignedMapMost = 1;
constexpr std::string_view kSignedMapScale =
    "-1 (blue: darker than the other) over 0 (white) to 1 (red: brighter), of both pictures' mean "
    "luminance";

// LDR-FLIP of each pixel, viridis.
Image flip_false_color(const Image& picture, const Image& reference);
constexpr std::string_view kFlipMapScale = "0 (dark) to 1 (bright)";

}  // namespace qray
