#include "server/sqlite/database.h"

#include <sqlite3.h>

#include <iterator>

namespace qray::server {
namespace {

// What makes version n + 1 of version n; the first makes version 1 of nothing.
constexpr const char* kSteps[] = {R"sql(
CREATE TABLE jobs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  state TEXT NOT NULL,
  request TEXT NOT NULL,          -- JSON
  created_ms INTEGER NOT NULL, started_ms INTEGER, ended_ms INTEGER,
  fraction REAL NOT NULL DEFAULT 0, samples INTEGER NOT NULL DEFAULT 0,
  seconds REAL NOT NULL DEFAULT 0,
  error_message TEXT, error_where TEXT,
  table_in TEXT NOT NULL DEFAULT '', table_out TEXT NOT NULL DEFAULT '',
  stats TEXT NOT NULL DEFAULT '', -- JSON
  biased INTEGER NOT NULL DEFAULT 0,
  warnings TEXT NOT NULL DEFAULT '',  -- a line each
  attempts INTEGER NOT NULL DEFAULT 0);
CREATE INDEX jobs_by_state ON jobs(state);
CREATE TABLE events (
  id INTEGER PRIMARY KEY,         -- rising across restarts, with gaps
  job TEXT NOT NULL, kind TEXT NOT NULL, data TEXT NOT NULL);
CREATE TABLE tables (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  scene TEXT NOT NULL, method TEXT NOT NULL,
  parents TEXT NOT NULL,          -- ids, a line each
  created_ms INTEGER NOT NULL,
  bytes INTEGER NOT NULL, states INTEGER NOT NULL, samples_seen INTEGER NOT NULL,
  job TEXT NOT NULL,
  geometry TEXT NOT NULL, materials TEXT NOT NULL, lights TEXT NOT NULL);
CREATE INDEX tables_by_scene ON tables(method, geometry, materials, lights);
CREATE TABLE counters (name TEXT PRIMARY KEY, value INTEGER NOT NULL);
)sql",
                                  R"sql(
CREATE TABLE job_log (
  id INTEGER PRIMARY KEY,
  job INTEGER NOT NULL,
  time_ms INTEGER NOT NULL, level TEXT NOT NULL, text TEXT NOT NULL);
CREATE INDEX job_log_by_job ON job_log(job, id);
CREATE TABLE idempotency_keys (
  key TEXT PRIMARY KEY,
  request TEXT NOT NULL,          -- SHA-256 of what was asked
  job INTEGER NOT NULL,
  created_ms INTEGER NOT NULL);
CREATE INDEX idempotency_keys_by_time ON idempotency_keys(created_ms);
CREATE INDEX events_by_job ON events(job);
)sql",
                                  R"sql(
CREATE INDEX jobs_by_table_in ON jobs(table_in) WHERE table_in <> '';
CREATE INDEX jobs_by_table_out ON jobs(table_out) WHERE table_out <> '';
CREATE TABLE job_labels (
  name TEXT NOT NULL, value TEXT NOT NULL, job INTEGER NOT NULL,
  PRIMARY KEY(name, value, job)) WITHOUT ROWID;  -- of jobs.request, by these triggers
CREATE INDEX job_labels_by_job ON job_labels(job);
INSERT INTO job_labels SELECT labels.key, labels.value, jobs.id FROM jobs,
  json_each(CASE WHEN json_valid(request) THEN request ELSE '{}' END, '$.labels') AS labels;
CREATE TRIGGER labels_of_a_new_job AFTER INSERT ON jobs BEGIN
  INSERT INTO job_labels SELECT key, value, new.id FROM json_each(new.request, '$.labels');
END;
CREATE TRIGGER labels_of_a_changed_job AFTER UPDATE OF request ON jobs
  WHEN old.request <> new.request BEGIN
  DELETE FROM job_labels WHERE job = new.id;
  INSERT INTO job_labels SELECT key, value, new.id FROM json_each(new.request, '$.labels');
END;
CREATE TRIGGER labels_of_a_deleted_job AFTER DELETE ON jobs BEGIN
  DELETE FROM job_labels WHERE job = old.id;
END;
)sql",
                                  R"sql(
ALTER TABLE jobs ADD COLUMN claim INTEGER NOT NULL DEFAULT 0;
CREATE INDEX jobs_by_times ON jobs(id, created_ms, ended_ms);
)sql",
                                  R"sql(
CREATE TABLE webhooks(id INTEGER PRIMARY KEY AUTOINCREMENT, url TEXT NOT NULL, secret TEXT NOT NULL,
  created_ms INTEGER NOT NULL, failures INTEGER NOT NULL DEFAULT 0,
  due_ms INTEGER NOT NULL DEFAULT 0);
CREATE TABLE deliveries(id INTEGER PRIMARY KEY AUTOINCREMENT, webhook INTEGER NOT NULL,
  job INTEGER NOT NULL, created_ms INTEGER NOT NULL);
CREATE INDEX deliveries_by_webhook ON deliveries(webhook);
)sql"};
constexpr int kSchemaVersion = std::size(kSteps);
constexpr int kReaders = 4;
constexpr int kBusyMs = 2000;
constexpr std::chrono::seconds kMostRead{2};

Error sqlite_error(sqlite3* db) {
  return {ErrorCode::kIo, std::string("SQLite: ") + sqlite3_errmsg(db), ""};
}

}  // namespace

Query::Query(sqlite3* db, const char* sql) : db_(db) {
  result_ = sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr);
}

Query::~Query() { sqlite3_finalize(statement_); }

Query& Query::bind(int64_t v) {
  sqlite3_bind_int64(statement_, ++bound_, v);
  return *this;
}

Query& Query::bind(double v) {
  sqlite3_bind_double(statement_, ++bound_, v);
  return *this;
}

Query& Query::bind(const std::string& v) {
  sqlite3_bind_text(statement_, ++bound_, v.data(), static_cast<int>(v.size()), SQLITE_TRANSIENT);
  return *this;
}

Query& Query::bind(std::nullopt_t) {
  sqlite3_bind_null(statement_, ++bound_);
  return *this;
}

bool Query::next() {
  if (!statement_) return false;
  result_ = sqlite3_step(statement_);
  return result_ == SQLITE_ROW;
}

Status Query::run() {
  while (next()) {
  }
  return status();
}

Status Query::status() const {
  if (result_ == SQLITE_OK || result_ == SQLITE_ROW || result_ == SQLITE_DONE) return {};
  return sqlite_error(db_);
}

bool Query::is_null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

int64_t Query::integer(int column) const { return sqlite3_column_int64(statement_, column); }

double Query::real(int column) const { return sqlite3_column_double(statement_, column); }

std::string Query::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return bytes ? std::string(bytes, static_cast<size_t>(sqlite3_column_bytes(statement_, column)))
               : std::string();
}

Result<std::unique_ptr<Database>> Database::open(const std::filesystem::path& file) {
  sqlite3* handle = nullptr;
  const int opened =
      sqlite3_open_v2(file.c_str(), &handle,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX, nullptr);
  std::unique_ptr<Database> db(new Database(handle));
  if (opened != SQLITE_OK) {
    Error error = sqlite_error(handle);
    error.where = file.string();
    return error;
  }
  sqlite3_busy_timeout(handle, kBusyMs);
  Status made = db->prepare_schema();
  if (made.ok()) made = db->open_readers(file);
  if (!made.ok()) {
    Error error = made.error();
    error.where = file.string();
    return error;
  }
  return db;
}

Database::~Database() {
  for (sqlite3* reader : free_readers_) sqlite3_close(reader);
  sqlite3_close(db_);
}

Status Database::open_readers(const std::filesystem::path& file) {
  for (int i = 0; i < kReaders; ++i) {
    sqlite3* reader = nullptr;
    const int opened =
        sqlite3_open_v2(file.c_str(), &reader, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
    free_readers_.push_back(reader);
    if (opened != SQLITE_OK) return sqlite_error(reader);
    sqlite3_busy_timeout(reader, kBusyMs);
  }
  return {};
}

Database::Reading::Reading(Database& db) : db_(db) {
  {
    std::unique_lock lock(db.readers_mutex_);
    db.reader_freed_.wait(lock, [&] { return !db.free_readers_.empty(); });
    reader_ = db.free_readers_.back();
    db.free_readers_.pop_back();
  }
  begun_ = std::chrono::steady_clock::now();
  constexpr int kStepsBetweenLooks = 10'000;
  const auto too_long = [](void* reading) {
    const auto begun = static_cast<Reading*>(reading)->begun_;
    return std::chrono::steady_clock::now() - begun > kMostRead ? 1 : 0;
  };
  sqlite3_progress_handler(reader_, kStepsBetweenLooks, too_long, this);
}

Database::Reading::~Reading() {
  sqlite3_progress_handler(reader_, 0, nullptr, nullptr);
  std::lock_guard lock(db_.readers_mutex_);
  db_.free_readers_.push_back(reader_);
  db_.reader_freed_.notify_one();
}

Status Database::prepare_schema() {
  Session session(*this);
  if (Status s = session.exec("PRAGMA journal_mode=WAL"); !s.ok()) return s;
  if (Status s = session.exec("PRAGMA synchronous=FULL"); !s.ok()) return s;
  int64_t version = 0;
  {
    Query query(db_, "PRAGMA user_version");
    if (query.next()) version = query.integer(0);
    if (Status s = query.status(); !s.ok()) return s;
  }
  if (version < 0 || version > kSchemaVersion) {
    return Error{ErrorCode::kUnsupported,
                 "the data folder has schema version " + std::to_string(version) +
                     ", expected at most " + std::to_string(kSchemaVersion),
                 ""};
  }
  is_new_ = version == 0;
  for (; version < kSchemaVersion; ++version) {
    Transaction transaction(*this);
    if (Status s = transaction.exec(kSteps[version]); !s.ok()) return s;
    const std::string mark = "PRAGMA user_version=" + std::to_string(version + 1);
    if (Status s = transaction.exec(mark.c_str()); !s.ok()) return s;
    if (Status s = transaction.commit(); !s.ok()) return s;
  }
  return {};
}

Status Database::Session::exec(const char* sql) {
  if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return sqlite_error(db_);
  return {};
}

Database::Transaction::~Transaction() {
  if (begun_.ok() && !committed_) (void)exec("ROLLBACK");
}

Status Database::Transaction::commit() {
  if (!begun_.ok()) return begun_;
  Status done = exec("COMMIT");
  committed_ = done.ok();
  return done;
}

}  // namespace qray::server
