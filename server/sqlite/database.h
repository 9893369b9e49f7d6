// SQLite behind values and Results: one connection that writes, durable at commit (WAL,
// synchronous=FULL), and a few that only read and wait for no writer. The schema is here. Any
// thread: a Session holds the writer's mutex, and one thread may nest them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

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
  bool is_new() const { return is_new_; }  // open() made it

  // One of the readers, waited for. It sees all that was committed before; it must not be used
  // where a Session is held, whose own writes it does not see. Reading for longer than two seconds
  // fails.
  class Reading {
   public:
    explicit Reading(Database& db);
    ~Reading();
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    sqlite3* handle() const { return reader_; }

   private:
    Database& db_;
    sqlite3* reader_;
    std::chrono::steady_clock::time_point begun_;
  };

  // Exclusive use of the connection that writes.
  class Session {
   public:
    explicit Session(Database& db) : lock_(db.mutex_), db_(db.db_) {}
    // Where others write: not waited for, and held() is false.
    Session(Database& db, std::try_to_lock_t) : lock_(db.mutex_, std::try_to_lock), db_(db.db_) {}
    bool held() const { return lock_.owns_lock(); }
    sqlite3* handle() const { return db_; }
    Status exec(const char* sql);

   private:
    std::unique_lock<std::recursive_mutex> lock_;
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
  Status open_readers(const std::filesystem::path& file);

  sqlite3* db_;
  bool is_new_ = false;
  std::recursive_mutex mutex_;
  std::mutex readers_mutex_;
  std::condition_variable reader_freed_;
  std::vector<sqlite3*> free_readers_;
};

}  // namespace qray::server
