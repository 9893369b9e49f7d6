#include "server/postgres/pg_database.h"

#include <thread>

namespace qray::server {
namespace {

using std::chrono::steady_clock;
constexpr int kConnections = 8;
constexpr std::chrono::milliseconds kTryAgain{300};  // to connect
constexpr std::chrono::seconds kMostAsking{4};       // what became of a transaction

}  // namespace

Result<std::unique_ptr<PgDatabase>> PgDatabase::open(const std::string& url) {
  const Result<const Libpq*> pq = Libpq::load();
  if (!pq.ok()) return pq.error();
  std::unique_ptr<PgDatabase> db(new PgDatabase(*pq.value(), url));
  const Result<bool> made = prepare_pg_schema(*db);
  if (!made.ok()) {
    Error error = made.error();
    error.where = db->name_;
    return error;
  }
  db->is_new_ = made.value();
  return db;
}

Result<std::unique_ptr<PgConnection>> PgDatabase::connect() const {
  return PgConnection::open(pq_, url_);
}

std::unique_ptr<PgConnection> PgDatabase::take() {
  std::unique_lock lock(mutex_);
  freed_.wait(lock, [&] { return out_ < kConnections; });
  ++out_;
  if (free_.empty()) return nullptr;
  auto connection = std::move(free_.back());
  free_.pop_back();
  return connection;
}

void PgDatabase::give_back(std::unique_ptr<PgConnection> connection) {
  std::lock_guard lock(mutex_);
  --out_;
  if (connection && connection->good()) free_.push_back(std::move(connection));
  freed_.notify_one();
}

PgDatabase::Session::Session(PgDatabase& db) : db_(db), connection_(db.take()) {}

PgDatabase::Session::~Session() { db_.give_back(std::move(connection_)); }

// While the database is away, callers learn so at once, and few of them knock.
Status PgDatabase::Session::connected() {
  if (connection_ && connection_->good()) return {};
  connection_.reset();
  {
    std::lock_guard lock(db_.mutex_);
    if (db_.away_ && steady_clock::now() - db_.tried_ < kTryAgain) return *db_.away_;
  }
  Result<std::unique_ptr<PgConnection>> made = db_.connect();
  std::lock_guard lock(db_.mutex_);
  db_.tried_ = steady_clock::now();
  db_.away_.reset();
  if (made.ok()) {
    connection_ = std::move(made).value();
    return {};
  }
  db_.away_ = made.error();
  return made.error();
}

Result<PgRows> PgDatabase::Session::run(const char* sql, const std::vector<PgValue>& values) {
  return run(sql, values, /*as_bytes=*/false);
}

Result<PgRows> PgDatabase::Session::run(const char* sql, const std::vector<PgValue>& values,
                                        bool as_bytes) {
  if (refused_) return *refused_;
  if (in_transaction_) return connection_->run(sql, values, as_bytes);
  if (Status s = connected(); !s.ok()) return s.error();
  Result<PgRows> rows = connection_->run(sql, values, as_bytes);
  if (rows.ok() || connection_->good()) return rows;
  if (Status s = connected(); !s.ok()) return s.error();
  return connection_->run(sql, values, as_bytes);
}

Status PgDatabase::Session::change(const char* sql, const std::vector<PgValue>& values) {
  const Result<PgRows> done = run(sql, values);
  return done.ok() ? Status() : Status(done.error());
}

// A connection that lay idle may have broken: that shows here, where nothing is lost.
PgDatabase::Transaction::Transaction(PgDatabase& db) : Session(db) {
  for (int tries = 0; tries < 2 && !in_transaction_; ++tries) {
    Status ready = connected();
    if (!ready.ok()) {
      refused_ = ready.error();
      return;
    }
    const Result<PgRows> begun = connection_->run_all("BEGIN; SELECT pg_current_xact_id()::text");
    if (begun.ok()) {
      number_ = begun.value().text(0, 0);
      in_transaction_ = true;
      refused_.reset();
    } else {
      refused_ = begun.error();
    }
  }
}

PgDatabase::Transaction::~Transaction() {
  if (in_transaction_ && !committed_ && connection_ && connection_->good())
    if (!connection_->run("ROLLBACK", {}).ok()) connection_.reset();
}

Status PgDatabase::Transaction::run_all(const char* sql) {
  if (refused_) return *refused_;
  const Result<PgRows> done = connection_->run_all(sql);
  return done.ok() ? Status() : Status(done.error());
}

Status PgDatabase::Transaction::commit() {
  const Result<PgRows> done = run("COMMIT");
  in_transaction_ = false;
  if (done.ok()) {
    committed_ = true;
    return {};
  }
  if (refused_ || connection_->good()) return done.error();  // it said no
  return outcome(done.error());
}

Status PgDatabase::Transaction::commit_soon() {
  if (const Result<PgRows> soon = run("SET LOCAL synchronous_commit TO off"); !soon.ok())
    return soon.error();
  return commit();
}

Status PgDatabase::Transaction::outcome(const Error& error) {
  const auto until = steady_clock::now() + kMostAsking;
  while (steady_clock::now() < until) {
    const Result<PgRows> became = run("SELECT pg_xact_status($1::xid8)", {number_});
    if (became.ok()) {
      const std::string status = became.value().text(0, 0);
      if (status == "committed") {
        committed_ = true;
        return {};
      }
      if (status != "in progress") return error;
    }
    std::this_thread::sleep_for(kTryAgain);
  }
  return Error{ErrorCode::kIo, error.message + "; whether it was recorded is not known", ""};
}

}  // namespace qray::server
