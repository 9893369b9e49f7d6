// From what was asked to what is rendered. Pure.
#pragma once

#include "core/render/settings.h"
#include "core/scene/scene.h"
#include "proto/messages.h"

namespace qray::server {

// Fills what the request leaves to the renderer: numbers that need no scene.
void fill_defaults(proto::JobRequest& request);
// The camera with what the request says of it.
Camera camera_of(const proto::CameraRequest& request, Camera camera);
// Fills what the request leaves to the scene: size, depth, camera members.
RenderSettings settings_of(const proto::JobRequest& request, const Scene& scene);

}  // namespace qray::server
