#include "core/render/pixel_probe.h"

namespace qray {
namespace {

Status check_coordinate(int value, int size, const char* pointer) {
  if (value >= 0 && value < size) return {};
  return Error{
      ErrorCode::kInvalid,
      "expected a pixel, 0.." + std::to_string(size - 1) + ", got " + std::to_string(value),
      pointer};
}

ProbedState probe_state(const PreparedScene& scene, const CameraRays& camera,
                        const GuideInspector& guide, const SeenSurface& seen) {
  ProbedState state;
  state.at = guide.find(seen.point.p, seen.facing);
  if (!state.at.state.valid()) return state;
  if (seen.guided) state.guide_fraction = guide.mixture(state.at, *seen.guided).guide;
  state.known = state.guide_fraction > 0;
  state.gain = guide.gain(state.at);
  state.summary = guide.summary(state.at);
  const float rod = kRodLength * length(scene.bounds.hi - scene.bounds.lo);
  for (const DirectionCell& cell : guide.directions(state.at))
    state.directions.push_back({cell, camera.project(seen.point.p + cell.wi * rod)});
  return state;
}

}  // namespace

Result<std::optional<PixelProbe>> probe_pixel(const PreparedScene& scene,
                                              const RenderSettings& settings,
                                              const GuideInspector* guide, int x, int y) {
  if (Status s = check_coordinate(x, settings.width, "/x"); !s.ok()) return s.error();
  if (Status s = check_coordinate(y, settings.height, "/y"); !s.ok()) return s.error();
  const CameraRays camera(settings.camera.value_or(scene.scene.camera), settings.width,
                          settings.height);
  const Vec2 pixel{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
  const std::optional<SeenSurface> seen = surface_seen(scene, camera.ray(pixel, {0.5f, 0.5f}));
  std::optional<PixelProbe> probe;
  if (!seen) return probe;
  probe = PixelProbe{*seen, std::nullopt};
  if (guide) probe->state = probe_state(scene, camera, *guide, *seen);
  return probe;
}

}  // namespace qray
