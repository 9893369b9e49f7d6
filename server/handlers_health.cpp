#include "server/handlers_health.h"

#include "server/reply.h"

namespace qray::server {

void add_health_routes(Router& router) {
  router.add("GET", "/healthz",
             [](auto&, auto& res, auto&) { reply_json(res, 200, proto::health_to_json()); });
}

}  // namespace qray::server
