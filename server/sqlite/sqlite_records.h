// All records in one SQLite file.
#pragma once

#include "server/sqlite/sqlite_job_store.h"
#include "server/sqlite/sqlite_table_index.h"
#include "server/sqlite/sqlite_webhook_store.h"
#include "server/store/records.h"

namespace qray::server {

class SqliteRecords final : public Records {
 public:
  // Jobs publish to `events`.
  static Result<std::unique_ptr<Records>> open(const std::filesystem::path& file, EventLog& events,
                                               const std::function<int64_t()>& now_ms) {
    Result<std::unique_ptr<Database>> db = Database::open(file);
    if (!db.ok()) return db.error();
    return std::unique_ptr<Records>(new SqliteRecords(std::move(db).value(), events, now_ms));
  }
  JobStore& jobs() override { return jobs_; }
  TableIndex& tables() override { return tables_; }
  WebhookStore& webhooks() override { return webhooks_; }

 private:
  SqliteRecords(std::unique_ptr<Database> db, EventLog& events,
                const std::function<int64_t()>& now_ms)
      : db_(std::move(db)), jobs_(*db_, events, now_ms), tables_(*db_), webhooks_(*db_, now_ms) {}

  const std::unique_ptr<Database> db_;
  SqliteJobStore jobs_;
  SqliteTableIndex tables_;
  SqliteWebhookStore webhooks_;
};

}  // namespace qray::server
