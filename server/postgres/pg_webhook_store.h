// Webhooks in PostgreSQL (webhook_store.h). Of several processes one tells a webhook at a time, so
// that it hears of each end once and in order. Any thread.
#pragma once

#include <functional>

#include "server/postgres/pg_database.h"
#include "server/store/webhook_store.h"

namespace qray::server {

class PgWebhookStore final : public WebhookStore {
 public:
  // `sender`: this process's name.
  PgWebhookStore(PgDatabase& db, std::function<int64_t()> now_ms, std::string sender)
      : db_(db), now_ms_(std::move(now_ms)), sender_(std::move(sender)) {}
  // In a transaction of others: the job has ended.
  static Status tell(PgDatabase::Transaction& transaction, JobId job, int64_t now_ms);

  Result<Webhook> add(const std::string& url, const std::string& secret) override;
  Result<std::vector<Webhook>> list() const override;
  Status remove(uint64_t id) override;
  Result<std::optional<Delivery>> next() const override;
  Status delivered(const Delivery& delivery) override;
  Status failed(const Delivery& delivery, int64_t delay_ms) override;
  Status give_up(const Delivery& delivery) override;

 private:
  PgDatabase& db_;
  const std::function<int64_t()> now_ms_;
  const std::string sender_;
};

}  // namespace qray::server
