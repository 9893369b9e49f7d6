// SQLite behind values and Results: one connection, one writer, durable at commit (WAL,
// synchronous=FULL). The schema is here. Any thread: a Session holds the connection's mutex, and
// one thread may nest them.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace qray::server {

// A prepared statement. Bind 1.. in order, then step through rows. Valid while its Session is.
class Query {
 public:
  Query(sqlite3* db, const char* sql);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  Query& bind(int64_t v);
  Query& bind(uint64_t v) { return bind(static_cast<int64_t>(v)); }
  Query& bind(int v) { return bind(int64_t{v}); }
  Query& bind(double v);
  Query& bind(const std::string& v);
  Query& bind(std::nullopt_t);
  template <class T>
  Query& bind(const std::optional<T>& v) {
    return v ? bind(*v) : bind(std::nullopt);
  }

  bool next();            // true: a row is there
  Status run();           // for statements without rows
  Status status() const;  // why next() was false, when it was not the end

  bool is_null(int column) const;
  int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;

 private:
  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  int result_ = 0;
};

class Database {
 public:
  static Result<std::unique_ptr<Database>> open(const std::filesystem::path& file);
  ~Database();

  // Exclusive use of the connection.
  class Session {
   public:
    explicit Session(Database& db) : lock_(db.mutex_), db_(db.db_) {}
    sqlite3* handle() const { return db_; }
    Status exec(const char* sql);

   private:
    std::lock_guard<std::recursive_mutex> lock_;
    sqlite3* db_;
  };

  // A Session in a transaction; rolled back unless commit() succeeded. Not to be nested.
  class Transaction : public Session {
   public:
    explicit Transaction(Database& db) : Session(db), begun_(exec("BEGIN IMMEDIATE")) {}
    ~Transaction();
    Status commit();

   private:
    Status begun_;
    bool committed_ = false;
  };

 private:
  explicit Database(sqlite3* db) : db_(db) {}
  Status prepare_schema();

  sqlite3* db_;
  std::recursive_mutex mutex_;
};

}  // namespace qray::server
