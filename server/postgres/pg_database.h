// A PostgreSQL database as a few connections that are shared, and made again when they broke. Any
// thread; no thread may hold two.
#pragma once

#include <condition_variable>
#include <mutex>

#include "server/postgres/pg_connection.h"

namespace qray::server {

class PgDatabase {
 public:
  class Transaction;
  // Brings the schema up to date. kUnsupported: a newer qray made it, or libpq is not there.
  static Result<std::unique_ptr<PgDatabase>> open(const std::string& url);
  bool is_new() const { return is_new_; }  // open() made the schema
  // Apart from the shared ones.
  Result<std::unique_ptr<PgConnection>> connect() const;
  const std::string& name() const { return name_; }  // for messages

  // One of the connections, waited for. It may be used again where the database went away between
  // two statements, so each statement must be one that may be run twice: reads, and changes that
  // are the same when they are made twice.
  class Session {
   public:
    explicit Session(PgDatabase& db);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    Result<PgRows> run(const char* sql, const std::vector<PgValue>& values = {});
    Result<PgRows> run(const std::string& sql, const std::vector<PgValue>& values = {}) {
      return run(sql.c_str(), values);
    }
    // All columns are text or bytea, which arrives as it is.
    Result<PgRows> run_bytes(const char* sql, const std::vector<PgValue>& values) {
      return run(sql, values, /*as_bytes=*/true);
    }
    // Of which no rows are wanted.
    Status change(const char* sql, const std::vector<PgValue>& values = {});

   private:
    Result<PgRows> run(const char* sql, const std::vector<PgValue>& values, bool as_bytes);
    friend class Transaction;
    Status connected();
    PgDatabase& db_;
    std::unique_ptr<PgConnection> connection_;
    bool in_transaction_ = false;
    std::optional<Error> refused_;  // a transaction that did not begin, or has ended
  };

  // Rolled back unless commit() succeeded.
  class Transaction : public Session {
   public:
    explicit Transaction(PgDatabase& db);
    ~Transaction();
    Status run_all(const char* sql);  // several statements, without values
    // Where the connection broke meanwhile, the database is asked what became of it; kIo: it did
    // not say, or it is undone.
    Status commit();
    // This commit may be lost with the database, though nothing of it alone. For what is only a
    // hint.
    Status commit_soon();

   private:
    Status outcome(const Error& error);
    std::string number_;  // the transaction's own, as the database knows it
    bool committed_ = false;
  };

 private:
  PgDatabase(const Libpq& pq, std::string url)
      : pq_(pq), url_(std::move(url)), name_(without_password(pq, url_)) {}
  std::unique_ptr<PgConnection> take();
  void give_back(std::unique_ptr<PgConnection> connection);

  const Libpq& pq_;
  const std::string url_, name_;
  bool is_new_ = false;
  std::mutex mutex_;
  std::condition_variable freed_;
  int out_ = 0;  // connections that somebody holds
  std::vector<std::unique_ptr<PgConnection>> free_;
  std::chrono::steady_clock::time_point tried_;  // to connect, in vain
  std::optional<Error> away_;                    // what that said
};

// What makes the tables, or brings them from an older version to this one's. Of one process at a
// time. True: they were not there.
Result<bool> prepare_pg_schema(PgDatabase& db);

}  // namespace qray::server
