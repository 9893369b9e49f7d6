// What is known at one pixel beside its colour: the surface seen there, the table's state, and the
// directions learned there. Any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/guide/guide_inspector.h"
#include "core/render/debug_view.h"
#include "core/render/prepared_scene.h"

namespace qray {

struct ProbedDirection {
  DirectionCell cell;
  // Pixel where a rod from the surface along the direction ends, kRodLength of the scene's diagonal
  // long; none: behind the camera.
  std::optional<Vec2> rod_end;
};
constexpr float kRodLength = 0.05f;

struct ProbedState {
  GuidePoint at;
  bool known = false;  // the guide is drawn from there
  float guide_fraction = 0, gain = 1;
  StateSummary summary;
  std::vector<ProbedDirection> directions;
};

struct PixelProbe {
  SeenSurface seen;
  std::optional<ProbedState> state;  // none: no guide was given
};

// Of the surface that is seen through the middle of the pixel (x, y) of the settings' picture; none
// is seen: nullopt. `guide` may be null. kInvalid names "/x" or "/y": outside of the picture.
Result<std::optional<PixelProbe>> probe_pixel(const PreparedScene& scene,
                                              const RenderSettings& settings,
                                              const GuideInspector* guide, int x, int y);

}  // namespace qray
