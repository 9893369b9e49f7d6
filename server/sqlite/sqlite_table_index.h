// The index of tables in a Database (table_index.h). Any thread.
#pragma once

#include "server/sqlite/database.h"
#include "server/store/table_index.h"

namespace qray::server {

class SqliteTableIndex final : public TableIndex {
 public:
  explicit SqliteTableIndex(Database& db) : db_(db) {}
  // In a transaction of others.
  static Status record(Database::Session& session, const TableRow& row);

  Status add(const TableRow& row) override;
  Result<std::vector<proto::TableInfo>> list(size_t limit,
                                             const std::string& before) const override;
  Result<std::vector<std::string>> ids() const override;
  Result<proto::TableInfo> find(const std::string& id) const override;
  Result<std::vector<std::string>> fitting(std::string_view method, const SceneHash& scene,
                                           size_t limit) const override;
  Status remove(const std::string& id) override;
  Status forget(const std::string& id) override;

 private:
  Database& db_;
};

}  // namespace qray::server
