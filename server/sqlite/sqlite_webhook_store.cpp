#include "server/sqlite/sqlite_webhook_store.h"

namespace qray::server {
namespace {

Webhook read_webhook(const Query& row) {
  return {static_cast<uint64_t>(row.integer(0)),
          row.text(1),
          row.text(2),
          row.integer(3),
          static_cast<uint64_t>(row.integer(4)),
          static_cast<uint64_t>(row.integer(5))};
}

}  // namespace

Status SqliteWebhookStore::tell(Database::Session& session, JobId job, int64_t now_ms) {
  return Query(session.handle(),
               "INSERT INTO deliveries(webhook, job, created_ms) SELECT id, ?1, ?2 FROM webhooks "
               "WHERE (SELECT COUNT(*) FROM deliveries WHERE webhook=webhooks.id) < ?3")
      .bind(job.value)
      .bind(now_ms)
      .bind(static_cast<int64_t>(kMostWaiting))
      .run();
}

Result<Webhook> SqliteWebhookStore::add(const std::string& url, const std::string& secret) {
  Webhook webhook;
  webhook.url = url;
  webhook.secret = secret;
  webhook.created_ms = now_ms_();
  Database::Transaction transaction(db_);
  Query count(transaction.handle(), "SELECT COUNT(*) FROM webhooks");
  if (count.next() && count.integer(0) >= static_cast<int64_t>(kMost))
    return Error{ErrorCode::kConflict, "there are " + std::to_string(kMost) + " webhooks already",
                 ""};
  if (Status s = count.status(); !s.ok()) return s.error();
  Query added(transaction.handle(),
              "INSERT INTO webhooks(url, secret, created_ms) VALUES(?,?,?) RETURNING id");
  added.bind(url).bind(secret).bind(webhook.created_ms);
  if (added.next()) webhook.id = static_cast<uint64_t>(added.integer(0));
  if (Status s = added.run(); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return webhook;
}

Result<std::vector<Webhook>> SqliteWebhookStore::list() const {
  const Database::Reading reading(db_);
  Query query(reading.handle(),
              "SELECT id, url, secret, created_ms, failures, (SELECT COUNT(*) FROM deliveries "
              "WHERE webhook=webhooks.id) FROM webhooks ORDER BY id");
  std::vector<Webhook> webhooks;
  while (query.next()) webhooks.push_back(read_webhook(query));
  if (Status s = query.status(); !s.ok()) return s.error();
  return webhooks;
}

Status SqliteWebhookStore::remove(uint64_t id) {
  Database::Transaction transaction(db_);
  Query gone(transaction.handle(), "DELETE FROM webhooks WHERE id=? RETURNING id");
  gone.bind(id);
  if (!gone.next())
    return gone.status().ok() ? Error{ErrorCode::kNotFound, "no such webhook", ""} : gone.status();
  if (Status s = gone.run(); !s.ok()) return s;
  Query waiting(transaction.handle(), "DELETE FROM deliveries WHERE webhook=?");
  if (Status s = waiting.bind(id).run(); !s.ok()) return s;
  return transaction.commit();
}

Result<std::optional<Delivery>> SqliteWebhookStore::next() const {
  const Database::Reading reading(db_);
  // A time that lies far ahead was written before the clock was turned back.
  Query query(reading.handle(),
              "SELECT webhooks.id, url, secret, webhooks.created_ms, failures, 0, deliveries.id, "
              "job, deliveries.created_ms FROM deliveries JOIN webhooks ON webhooks.id=webhook "
              "WHERE due_ms<=?1 OR due_ms>?1+?2 ORDER BY deliveries.id LIMIT 1");
  query.bind(now_ms_()).bind(kLongestDelayMs);
  std::optional<Delivery> delivery;
  if (query.next())
    delivery = Delivery{static_cast<uint64_t>(query.integer(6)), read_webhook(query),
                        JobId{static_cast<uint64_t>(query.integer(7))}, query.integer(8)};
  if (Status s = query.status(); !s.ok()) return s.error();
  return delivery;
}

Status SqliteWebhookStore::delivered(const Delivery& delivery) {
  Database::Transaction transaction(db_);
  Query gone(transaction.handle(), "DELETE FROM deliveries WHERE id=?");
  if (Status s = gone.bind(delivery.id).run(); !s.ok()) return s;
  Query good(transaction.handle(), "UPDATE webhooks SET failures=0 WHERE id=? AND failures>0");
  if (Status s = good.bind(delivery.webhook.id).run(); !s.ok()) return s;
  return transaction.commit();
}

Status SqliteWebhookStore::failed(const Delivery& delivery, int64_t delay_ms) {
  Database::Session session(db_);
  return Query(session.handle(), "UPDATE webhooks SET failures=failures+1, due_ms=? WHERE id=?")
      .bind(now_ms_() + delay_ms)
      .bind(delivery.webhook.id)
      .run();
}

Status SqliteWebhookStore::give_up(const Delivery& delivery) {
  Database::Session session(db_);
  return Query(session.handle(), "DELETE FROM deliveries WHERE id=?").bind(delivery.id).run();
}

}  // namespace qray::server
