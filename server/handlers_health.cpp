#include "server/handlers_health.h"

#include "server/reply.h"

namespace qray::server {

void add_health_routes(Router& router, std::string openapi_json) {
  router.add("GET", "/healthz",
             [](auto&, auto& res, auto&) { reply_json(res, 200, proto::health_to_json()); });
  router.add("GET", "/openapi.json", [json = std::move(openapi_json)](auto&, auto& res, auto&) {
    reply_json(res, 200, json);
  });
}

}  // namespace qray::server
