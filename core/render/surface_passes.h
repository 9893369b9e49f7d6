// What the camera sees, without light: pictures of surfaces, made of rays of their own that are
// those of a render's first samples, so that neither a render's loop nor its state knows of them.
// Any thread.
#pragma once

#include <stop_token>

#include "core/base/task_pool.h"
#include "core/image/picture_layers.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// Rays of a pixel, for what is averaged over it; of one whose first rays see different things.
constexpr int kFewPassRays = 8, kManyPassRays = 32;
// Depth, and what a position's members are, where no surface is.
constexpr float kNoDepth = 1e10f;

struct SurfacePasses {
  std::vector<PictureLayer> layers;
  ImageMetadata metadata;
};

// What motion is told against: the frames beside this one.
struct NeighbourFrame {
  const Camera* camera = nullptr;        // null: there is no such frame
  const PreparedScene* scene = nullptr;  // as it is then; null: its surfaces stand still
};
struct NeighbourFrames {
  NeighbourFrame before, after;
};

// Those of the settings' passes that are of surfaces. kCanceled when stopped.
Result<SurfacePasses> render_surface_passes(const PreparedScene& scene,
                                            const RenderSettings& settings,
                                            const NeighbourFrames& neighbours, TaskPool& pool,
                                            std::stop_token stop);

// The names by which passes call what a hit's mesh is, and the materials.
std::vector<std::string> object_names(const Scene& scene);
std::vector<std::string> material_names(const Scene& scene);

}  // namespace qray
