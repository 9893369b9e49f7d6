// GET /v1/tables: what was learned, newest first. Any thread.
#pragma once

#include "server/router.h"
#include "server/store/table_store.h"

namespace qray::server {

void add_table_routes(Router& router, const TableStore& tables);

}  // namespace qray::server
