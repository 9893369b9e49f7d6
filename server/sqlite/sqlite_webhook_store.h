// Webhooks in a Database (webhook_store.h). Any thread.
#pragma once

#include <functional>

#include "server/sqlite/database.h"
#include "server/store/webhook_store.h"

namespace qray::server {

class SqliteWebhookStore final : public WebhookStore {
 public:
  SqliteWebhookStore(Database& db, std::function<int64_t()> now_ms)
      : db_(db), now_ms_(std::move(now_ms)) {}
  // In a transaction of others: the job has ended.
  static Status tell(Database::Session& session, JobId job, int64_t now_ms);

  Result<Webhook> add(const std::string& url, const std::string& secret) override;
  Result<std::vector<Webhook>> list() const override;
  Status remove(uint64_t id) override;
  Result<std::optional<Delivery>> next() const override;
  Status delivered(const Delivery& delivery) override;
  Status failed(const Delivery& delivery, int64_t delay_ms) override;
  Status give_up(const Delivery& delivery) override;

 private:
  Database& db_;
  const std::function<int64_t()> now_ms_;
};

}  // namespace qray::server
