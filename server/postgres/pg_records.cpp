#include "server/postgres/pg_records.h"

#include "server/postgres/pg_job_store.h"
#include "server/postgres/pg_shared_passes.h"
#include "server/postgres/pg_table_index.h"
#include "server/postgres/pg_webhook_store.h"

namespace qray::server {
namespace {

class PgRecords final : public Records {
 public:
  PgRecords(std::unique_ptr<PgDatabase> db, EventLog& events,
            const std::function<int64_t()>& now_ms, const PgOptions& options)
      : db_(std::move(db)),
        jobs_(*db_, events, now_ms, options),
        tables_(*db_),
        webhooks_(*db_, now_ms, jobs_.worker()),
        passes_(*db_, jobs_.worker()) {}
  JobStore& jobs() override { return jobs_; }
  TableIndex& tables() override { return tables_; }
  WebhookStore& webhooks() override { return webhooks_; }
  SharedJobs* shared() override { return &jobs_; }
  SharedPasses* passes() override { return &passes_; }

 private:
  const std::unique_ptr<PgDatabase> db_;
  PgJobStore jobs_;
  PgTableIndex tables_;
  PgWebhookStore webhooks_;
  PgSharedPasses passes_;
};

}  // namespace

Result<std::unique_ptr<Records>> open_pg_records(const std::string& url, EventLog& events,
                                                 const std::function<int64_t()>& now_ms,
                                                 const PgOptions& options) {
  Result<std::unique_ptr<PgDatabase>> db = PgDatabase::open(url);
  if (!db.ok()) return db.error();
  return std::unique_ptr<Records>(
      std::make_unique<PgRecords>(std::move(db).value(), events, now_ms, options));
}

}  // namespace qray::server
