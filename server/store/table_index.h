// What is known of the learned tables without their files. Each call is a transaction, durable when
// it returns. Any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/scene_hash.h"
#include "proto/messages.h"

namespace qray::server {

struct TableRow {
  proto::TableInfo info;
  SceneHash scene;  // that it was learned from
};

class TableIndex {
 public:
  virtual ~TableIndex() = default;

  // One of an id that is there takes its place, as the newest.
  virtual Status add(const TableRow& row) = 0;
  // Newest first; those before a table (kNotFound), or all.
  virtual Result<std::vector<proto::TableInfo>> list(size_t limit,
                                                     const std::string& before) const = 0;
  virtual Result<std::vector<std::string>> ids() const = 0;
  virtual Result<proto::TableInfo> find(const std::string& id) const = 0;  // kNotFound
  // Those that have seen the most first, of these the newest.
  virtual Result<std::vector<std::string>> fitting(std::string_view method, const SceneHash& scene,
                                                   size_t limit) const = 0;
  // kNotFound; kConflict: a job that has not ended names it.
  virtual Status remove(const std::string& id) = 0;
  virtual Status forget(const std::string& id) = 0;  // whoever names it
};

}  // namespace qray::server
