// Events of jobs: how they get their ids, and how each process publishes those of all.
#include <spdlog/spdlog.h>

#include <unistd.h>

#include <algorithm>

#include "core/base/process_name.h"

#include "server/postgres/pg_job_store.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
constexpr int64_t kEventsKept = 2'000;  // that a process remembers at its start
constexpr int64_t kEventsAtOnce = 1'000;
constexpr int64_t kEventsInPart = 25'000;  // of four parts, of which the oldest is emptied
constexpr int64_t kParts = 4;
constexpr size_t kMostHints = 1'000;  // that wait to be written
constexpr milliseconds kLook{250}, kStopsWithin{25};
constexpr milliseconds kConnectAgain{1'000};

std::atomic<int> stores = 0;  // of this process: tests have several

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && *name ? name : "host";
}

}  // namespace

PgJobStore::PgJobStore(PgDatabase& db, EventLog& events, std::function<int64_t()> now_ms,
                       PgOptions options)
    : db_(db),
      events_(events),
      now_ms_(std::move(now_ms)),
      options_(options),
      host_(host_name()),
      worker_(host_ + "-" + process_name() + "-" + std::to_string(++stores)) {}

PgJobStore::~PgJobStore() {
  follower_ = {};
  (void)write_hints();
}

Status PgJobStore::write_event(Transaction& transaction, const Event& event, bool hint) {
  return transaction.change("INSERT INTO new_events(job, kind, data, hint) VALUES($1,$2,$3,$4)",
                            {event.job, event.kind, event.data, hint});
}

void PgJobStore::publish_hint(Event event) {
  std::lock_guard lock(hints_mutex_);
  hints_.push_back(std::move(event));
  if (hints_.size() > kMostHints) hints_.erase(hints_.begin());
}

Status PgJobStore::write_hints() {
  std::vector<Event> hints;
  {
    std::lock_guard lock(hints_mutex_);
    hints.swap(hints_);
  }
  if (hints.empty()) return {};
  Transaction transaction(db_);
  for (const Event& event : hints)
    if (Status s = write_event(transaction, event, /*hint=*/true); !s.ok()) return s;
  return transaction.commit_soon();
}

// By one process at a time, until it commits: who sees an id sees all before it.
Status PgJobStore::number_events(Transaction& transaction) {
  if (Status s = transaction.change("SELECT pg_advisory_xact_lock(hashtext('qray events'))");
      !s.ok())
    return s;
  const Result<PgRows> last = transaction.run("SELECT last_value FROM event_ids");
  if (!last.ok()) return last.error();
  // The part that comes next is the oldest one: it is emptied before.
  const int64_t block = (last.value().integer(0, 0) + kEventsAtOnce) / kEventsInPart;
  const std::string part = "events_" + std::to_string(block % kParts);
  const Result<PgRows> old =
      transaction.run("SELECT 1 FROM " + part + " WHERE id<$1 LIMIT 1", {block * kEventsInPart});
  if (!old.ok()) return old.error();
  if (!old.value().empty())
    if (Status s = transaction.change(("TRUNCATE " + part).c_str()); !s.ok()) return s;
  return transaction.change(
      "WITH taken AS (DELETE FROM new_events WHERE place <= (SELECT max(place) FROM (SELECT place "
      "FROM new_events ORDER BY place LIMIT $1) AS first) RETURNING *), numbered AS MATERIALIZED "
      "(SELECT nextval('event_ids') AS id, job, kind, data, hint FROM (SELECT * FROM taken ORDER "
      "BY "
      "place) AS ordered) INSERT INTO events SELECT id, (id / $2) % $3, job, kind, data, hint "
      "FROM numbered",
      {kEventsAtOnce, kEventsInPart, kParts});
}

Status PgJobStore::restore_events() {
  if (options_.publishes)
    if (Status s = restore_log(); !s.ok()) return s;
  follower_ = std::jthread([this](std::stop_token stop) { follow(std::move(stop)); });
  return {};
}

Status PgJobStore::restore_log() {
  uint64_t newest = 0;
  std::vector<Event> events;
  for (bool more = true; more;) {
    Transaction transaction(db_);
    if (Status s = number_events(transaction); !s.ok()) return s;
    const Result<PgRows> rows = transaction.run(
        "SELECT id, job, kind, data FROM events WHERE NOT hint ORDER BY id DESC LIMIT $1",
        {kEventsKept});
    if (!rows.ok()) return rows.error();
    const Result<PgRows> next = transaction.run(
        "SELECT CASE WHEN is_called THEN nextval('event_ids') ELSE 0 END, "
        "EXISTS(SELECT 1 FROM new_events) FROM event_ids");
    if (!next.ok()) return next.error();
    more = next.value().text(0, 1) == "t";
    newest = next.value().number(0, 0);
    events.clear();
    for (int row = rows.value().size(); row-- > 0;)
      events.push_back({rows.value().number(row, 0), rows.value().text(row, 1),
                        rows.value().text(row, 2), rows.value().text(row, 3)});
    if (Status s = transaction.commit(); !s.ok()) return s;
  }
  const uint64_t lost = events.empty() ? newest : events.front().id - 1;
  std::lock_guard lock(publish_mutex_);
  published_ = newest;
  events_.restore(lost, std::move(events), newest);
  return {};
}

void PgJobStore::publish_new() {
  if (!options_.publishes) return;
  std::lock_guard lock(publish_mutex_);
  const Status done = read_new();
  if (!done.ok() && !std::exchange(publish_failed_, true))
    spdlog::error("events are late: {}", done.error().text());
  if (done.ok() && std::exchange(publish_failed_, false)) spdlog::info("events come again");
}

Status PgJobStore::read_new() {
  for (;;) {
    const auto waiting = [&]() -> Result<PgRows> {
      PgDatabase::Session session(db_);
      return session.run("SELECT 1 FROM new_events LIMIT 1");
    }();
    if (!waiting.ok()) return waiting.error();
    if (!waiting.value().empty()) {
      Transaction transaction(db_);
      if (Status s = number_events(transaction); !s.ok()) return s;
      if (Status s = transaction.commit(); !s.ok()) return s;
    }
    PgDatabase::Session session(db_);
    const Result<PgRows> rows =
        session.run("SELECT id, job, kind, data FROM events WHERE id>$1 ORDER BY id LIMIT $2",
                    {published_, kEventsAtOnce});
    if (!rows.ok()) return rows.error();
    for (int row = 0; row < rows.value().size(); ++row) {
      published_ = rows.value().number(row, 0);
      events_.publish({published_, rows.value().text(row, 1), rows.value().text(row, 2),
                       rows.value().text(row, 3)});
    }
    if (waiting.value().empty() && rows.value().size() < kEventsAtOnce) return {};
  }
}

void PgJobStore::tell_others() {
  Transaction transaction(db_);
  if (transaction.change("NOTIFY qray").ok()) (void)transaction.commit_soon();
}

void PgJobStore::wait_for_news(std::stop_token stop, milliseconds time) {
  std::unique_lock lock(news_mutex_);
  const uint64_t known = news_;
  news_came_.wait_for(lock, stop, time, [&] { return news_ != known; });
}

// Hears what others tell, writes hints, and publishes what others did. What is heard only spares a
// wait: all is looked at anyway.
void PgJobStore::follow(std::stop_token stop) {
  std::unique_ptr<PgConnection> ear;
  auto tried = std::chrono::steady_clock::now() - kConnectAgain;
  while (!stop.stop_requested()) {
    if (ear && !ear->good()) ear.reset();
    if (const auto now = std::chrono::steady_clock::now(); !ear && now - tried >= kConnectAgain) {
      tried = now;
      Result<std::unique_ptr<PgConnection>> made = db_.connect();
      if (made.ok() && made.value()->run("LISTEN qray", {}).ok()) ear = std::move(made).value();
    }
    bool heard = false;
    const auto until = std::chrono::steady_clock::now() + kLook;
    while (!heard && !stop.stop_requested() && std::chrono::steady_clock::now() < until) {
      if (!ear || !ear->good()) {
        std::this_thread::sleep_for(kStopsWithin);
        continue;
      }
      const auto told = ear->notifications(kStopsWithin);
      heard = told.ok() && !told.value().empty();
    }
    if (heard) {
      std::lock_guard lock(news_mutex_);
      ++news_;
      news_came_.notify_all();
    }
    (void)write_hints();
    publish_new();
  }
}

}  // namespace qray::server
