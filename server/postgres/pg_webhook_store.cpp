#include "server/postgres/pg_webhook_store.h"

namespace qray::server {
namespace {

// From the column `first` on: id, url, secret, created_ms, failures, waiting.
Webhook read_pg_webhook(const PgRows& rows, int row) {
  return {rows.number(row, 0),  rows.text(row, 1),   rows.text(row, 2),
          rows.integer(row, 3), rows.number(row, 4), rows.number(row, 5)};
}

}  // namespace

Status PgWebhookStore::tell(PgDatabase::Transaction& transaction, JobId job, int64_t now_ms) {
  return transaction.change(
      "INSERT INTO deliveries(webhook, job, created_ms) SELECT id, $1, $2 FROM webhooks "
      "WHERE (SELECT count(*) FROM deliveries WHERE webhook=webhooks.id) < $3",
      {job.value, now_ms, uint64_t{kMostWaiting}});
}

Result<Webhook> PgWebhookStore::add(const std::string& url, const std::string& secret) {
  Webhook webhook;
  webhook.url = url;
  webhook.secret = secret;
  webhook.created_ms = now_ms_();
  PgDatabase::Transaction transaction(db_);
  if (Status s = transaction.change("SELECT pg_advisory_xact_lock(hashtext('qray webhooks'))");
      !s.ok())
    return s.error();
  const Result<PgRows> count = transaction.run("SELECT count(*) FROM webhooks");
  if (!count.ok()) return count.error();
  if (count.value().number(0, 0) >= kMost)
    return Error{ErrorCode::kConflict, "there are " + std::to_string(kMost) + " webhooks already",
                 ""};
  const Result<PgRows> added =
      transaction.run("INSERT INTO webhooks(url, secret, created_ms) VALUES($1,$2,$3) RETURNING id",
                      {url, secret, webhook.created_ms});
  if (!added.ok()) return added.error();
  webhook.id = added.value().number(0, 0);
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return webhook;
}

Result<std::vector<Webhook>> PgWebhookStore::list() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT id, url, secret, created_ms, failures, (SELECT count(*) FROM deliveries "
      "WHERE webhook=webhooks.id) FROM webhooks ORDER BY id");
  if (!rows.ok()) return rows.error();
  std::vector<Webhook> webhooks;
  for (int row = 0; row < rows.value().size(); ++row)
    webhooks.push_back(read_pg_webhook(rows.value(), row));
  return webhooks;
}

Status PgWebhookStore::remove(uint64_t id) {
  PgDatabase::Transaction transaction(db_);
  const Result<PgRows> gone =
      transaction.run("DELETE FROM webhooks WHERE id=$1 RETURNING id", {id});
  if (!gone.ok()) return gone.error();
  if (gone.value().empty()) return Error{ErrorCode::kNotFound, "no such webhook", ""};
  if (Status s = transaction.change("DELETE FROM deliveries WHERE webhook=$1", {id}); !s.ok())
    return s;
  return transaction.commit();
}

// The webhook is this process's for a minute: longer than a delivery takes.
Result<std::optional<Delivery>> PgWebhookStore::next() const {
  std::optional<Delivery> delivery;
  PgDatabase::Session look(db_);
  // A time that lies far ahead was written before the clock was turned back.
  const std::string due =
      "(due_ms<=$1 OR due_ms>$1::bigint+$2) AND (sender IS NULL OR sender=$3 OR "
      "sends_until<clock_timestamp())";
  const Result<PgRows> oldest = look.run(
      "SELECT webhooks.id, deliveries.id, job, deliveries.created_ms FROM deliveries JOIN "
      "webhooks ON webhooks.id=webhook WHERE " +
          due + " ORDER BY deliveries.id LIMIT 1",
      {now_ms_(), kLongestDelayMs, sender_});
  if (!oldest.ok()) return oldest.error();
  if (oldest.value().empty()) return delivery;
  // One statement that may be run twice; none: another process took it meanwhile.
  const Result<PgRows> taken = look.run(
      "UPDATE webhooks SET sender=$3, sends_until=clock_timestamp() + interval '1 minute' "
      "WHERE id=$4 AND " +
          due +
          " AND EXISTS(SELECT 1 FROM deliveries WHERE id=$5) "
          "RETURNING id, url, secret, created_ms, failures, 0",
      {now_ms_(), kLongestDelayMs, sender_, oldest.value().number(0, 0),
       oldest.value().number(0, 1)});
  if (!taken.ok()) return taken.error();
  if (!taken.value().empty())
    delivery = Delivery{oldest.value().number(0, 1), read_pg_webhook(taken.value(), 0),
                        JobId{oldest.value().number(0, 2)}, oldest.value().integer(0, 3)};
  return delivery;
}

Status PgWebhookStore::delivered(const Delivery& delivery) {
  PgDatabase::Transaction transaction(db_);
  if (Status s = transaction.change("DELETE FROM deliveries WHERE id=$1", {delivery.id}); !s.ok())
    return s;
  if (Status s = transaction.change("UPDATE webhooks SET failures=0 WHERE id=$1 AND failures>0",
                                    {delivery.webhook.id});
      !s.ok())
    return s;
  return transaction.commit();
}

Status PgWebhookStore::failed(const Delivery& delivery, int64_t delay_ms) {
  PgDatabase::Transaction transaction(db_);
  if (Status s =
          transaction.change("UPDATE webhooks SET failures=failures+1, due_ms=$2 WHERE id=$1",
                             {delivery.webhook.id, now_ms_() + delay_ms});
      !s.ok())
    return s;
  return transaction.commit();
}

Status PgWebhookStore::give_up(const Delivery& delivery) {
  PgDatabase::Transaction transaction(db_);
  if (Status s = transaction.change("DELETE FROM deliveries WHERE id=$1", {delivery.id}); !s.ok())
    return s;
  return transaction.commit();
}

}  // namespace qray::server
