// The directions learned at one surface, as a picture. Any thread.
#pragma once

#include <string_view>

#include "core/guide/guide_inspector.h"
#include "core/image/image.h"
#include "core/render/prepared_scene.h"

namespace qray {

// Densities per steradian at the ends of the scale, which is logarithmic (viridis). The uniform
// hemisphere's is 0.16.
constexpr float kLobeLow = 0.01f, kLobeHigh = 100;
constexpr std::string_view kLobeScale =
    "0.01 (dark) to 100 (bright) per steradian, logarithmic; grey: into the surface";
constexpr int kLobeWidth = 512, kLobeHeight = 256;  // pixels, of the sphere

struct LobeView {
  Image image;
  bool known = false;  // the table guides there; else the surface's hemisphere is black
};

// At the surface that is seen through the middle of the pixel (x, y) of the settings' picture: the
// sphere of directions in world space, equirectangular: +y at the top, +z in the middle, -x right
// and +x left of it, -z at both ends. Directions into the surface are grey, or greyed where the
// guide draws them. For the thesis' method the 26 directions stand beside it as a cube, each with
// its learned value from 0 (dark) to the largest (bright), grey below the horizon.
// kInvalid names "/x" or "/y": outside of the picture, or no surface is seen.
Result<LobeView> render_lobe_view(const PreparedScene& scene, const RenderSettings& settings,
                                  const GuideInspector& guide, int x, int y);

}  // namespace qray
