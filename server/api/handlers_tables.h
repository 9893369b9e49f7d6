// Tables: what was learned. List, look, download, upload, merge, delete. A merge is a request's own
// work: some seconds at most, one at a time. So is an upload, whose table is checked. Any thread.
#pragma once

#include <functional>
#include <mutex>

#include "server/http/router.h"
#include "server/store/table_store.h"

namespace qray::server {

class TableHandlers {
 public:
  // `now_ms`: the time of day.
  TableHandlers(TableStore& tables, const proto::RequestLimits& limits,
                std::function<int64_t()> now_ms)
      : tables_(tables), limits_(limits), now_ms_(std::move(now_ms)) {}
  void add_to(Router& router);

 private:
  void list(const httplib::Request& req, httplib::Response& res) const;
  void file(httplib::Response& res, const std::string& id) const;
  void upload(const httplib::Request& req, httplib::Response& res,
              const httplib::ContentReader& body);
  // The new table's, or that of the same table, which is there.
  Result<proto::TableInfo> uploaded(std::span<const uint8_t> bytes, const std::string& scene,
                                    bool& is_new);
  void merge(const httplib::Request& req, httplib::Response& res);
  Result<proto::TableInfo> merged(const std::vector<proto::TableInfo>& infos);

  TableStore& tables_;
  const proto::RequestLimits limits_;
  std::function<int64_t()> now_ms_;
  std::timed_mutex merging_;
  std::mutex uploading_;  // one is in memory at a time
};

}  // namespace qray::server
