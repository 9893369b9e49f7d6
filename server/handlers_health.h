// GET /healthz: the server answers; GET /openapi.json: what it speaks. Any thread.
#pragma once

#include <string>

#include "server/router.h"

namespace qray::server {

void add_health_routes(Router& router, std::string openapi_json);

}  // namespace qray::server
