// Feature pictures without light, of what the camera sees first: albedo, shading normal, and what a
// table knows there. Any thread.
#pragma once

#include <optional>
#include <stop_token>
#include <string_view>

#include "core/base/task_pool.h"
#include "core/guide/guide.h"
#include "core/image/image.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// kBeta and kGain are viridis; black where nothing is guided: no surface, or a mirror.
enum class DebugView {
  kAlbedo,  // linear
  kNormal,  // (n + 1) / 2, world space
  kState,   // one colour a state (figure 8 of the thesis), black where the table has none; of a
            // guide that has learned nothing: the states that it would have
  kBeta,    // the chance to draw from the guide rather than the BSDF, 0 to 1
  kGain,    // GuideInspector::gain(), 1 to kGainHigh, logarithmic
};
constexpr float kGainHigh = 64;

std::optional<DebugView> parse_debug_view(std::string_view name);  // "albedo" .. "gain"
std::string_view scale_of(DebugView view);                         // which colour is which number
constexpr bool shows_guide(DebugView view) { return view >= DebugView::kState; }

struct SeenSurface {
  SurfacePoint point;
  Hit hit;
  const MeshShading* mesh;
  Vec3 facing;                          // the geometric normal on the side that is seen
  std::optional<GuidedSurface> guided;  // none: a mirror or clear glass, where no guide is asked
};
std::optional<SeenSurface> surface_seen(const PreparedScene& scene, const Ray& ray);

// Uses the settings' size, camera and seed; `samples_per_pixel` for smooth edges. `guide`: may be
// null where shows_guide() says no.
Result<Image> render_debug_view(const PreparedScene& scene, const RenderSettings& settings,
                                DebugView view, const Guide* guide, int samples_per_pixel,
                                TaskPool& pool, std::stop_token stop);

// The colour that kState gives to the state with this key.
Rgb state_color(uint64_t key);

}  // namespace qray
