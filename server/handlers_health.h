// GET /healthz: the server answers. Any thread.
#pragma once

#include "server/router.h"

namespace qray::server {

void add_health_routes(Router& router);

}  // namespace qray::server
