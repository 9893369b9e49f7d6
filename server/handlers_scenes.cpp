#include "server/handlers_scenes.h"

#include "server/reply.h"

namespace qray::server {

void add_scene_routes(Router& router, SceneStore& scenes) {
  router.add("GET", "/v1/scenes", [&scenes](auto&, auto& res, auto&) {
    reply_json(res, 200, proto::scene_list_to_json(scenes.list()));
  });
}

}  // namespace qray::server
