// Feature pictures without light: what the camera sees first, as albedo, shading normal, or the
// state of the guide's table it falls in (figure 8 of the thesis). Any thread.
#pragma once

#include <stop_token>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/render/prepared_scene.h"
#include "core/render/settings.h"

namespace qray {

enum class DebugView {
  kAlbedo,  // linear
  kNormal,  // (n + 1) / 2, world space
  kState,   // one colour a state; of `huang`'s grid when the method has no states
};

// Uses the settings' size, camera, seed, method and grid; `samples_per_pixel` for smooth edges.
Result<Image> render_debug_view(const PreparedScene& scene, const RenderSettings& settings,
                                DebugView view, int samples_per_pixel, TaskPool& pool,
                                std::stop_token stop);

// The colour that kState gives to the state with this key.
Rgb state_color(uint64_t key);

}  // namespace qray
