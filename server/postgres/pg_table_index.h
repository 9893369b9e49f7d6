// The index of tables in PostgreSQL (table_index.h). Any thread.
#pragma once

#include "server/postgres/pg_database.h"
#include "server/store/table_index.h"

namespace qray::server {

class PgTableIndex final : public TableIndex {
 public:
  explicit PgTableIndex(PgDatabase& db) : db_(db) {}
  // In a transaction of others.
  static Status record(PgDatabase::Transaction& transaction, const TableRow& row);

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
  PgDatabase& db_;
};

}  // namespace qray::server
