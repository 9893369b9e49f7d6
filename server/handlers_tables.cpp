#include "server/handlers_tables.h"

#include "server/reply.h"

namespace qray::server {

void add_table_routes(Router& router, const TableStore& tables) {
  router.add("GET", "/v1/tables", [&tables](auto&, auto& res, auto&) {
    const Result<std::vector<proto::TableInfo>> list = tables.list();
    if (!list.ok()) return reply_error(res, list.error());
    reply_json(res, 200, proto::table_list_to_json(list.value()));
  });
}

}  // namespace qray::server
