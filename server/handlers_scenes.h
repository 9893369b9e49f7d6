// GET /v1/scenes: the names that a job may ask for. Any thread.
#pragma once

#include "server/router.h"
#include "server/store/scene_store.h"

namespace qray::server {

void add_scene_routes(Router& router, SceneStore& scenes);

}  // namespace qray::server
