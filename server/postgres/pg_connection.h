// One connection to PostgreSQL behind values and Results. Every wait ends: for the connection after
// 5 s, for a statement after 5 s at the database and 10 s here. One thread at a time.
#pragma once

#include <chrono>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/postgres/libpq.h"

namespace qray::server {

// What stands for $1, $2, ... in a statement; none: NULL.
class PgValue {
 public:
  PgValue(std::nullopt_t) {}
  PgValue(std::string text) : text_(std::move(text)) {}
  PgValue(std::string_view text) : text_(text) {}
  PgValue(const char* text) : text_(text) {}
  PgValue(bool v) : text_(v ? "t" : "f") {}
  PgValue(int v) : text_(std::to_string(v)) {}
  PgValue(int64_t v) : text_(std::to_string(v)) {}
  PgValue(uint64_t v) : PgValue(static_cast<int64_t>(v)) {}
  PgValue(double v);
  explicit PgValue(const std::vector<uint8_t>& bytes)  // of bytea
      : text_(std::string(bytes.begin(), bytes.end())), binary_(true) {}
  template <class T>
  PgValue(const std::optional<T>& v) {
    if (v) *this = PgValue(*v);
  }
  const char* text() const { return text_ ? text_->c_str() : nullptr; }
  int size() const { return text_ ? static_cast<int>(text_->size()) : 0; }
  bool binary() const { return binary_; }

 private:
  std::optional<std::string> text_;
  bool binary_ = false;
};

// The rows of an answer.
class PgRows {
 public:
  PgRows(const Libpq& pq, PGresult* result) : pq_(&pq), result_(result, pq.clear) {}
  int size() const { return pq_->ntuples(result_.get()); }
  bool empty() const { return size() == 0; }
  bool is_null(int row, int column) const { return pq_->getisnull(result_.get(), row, column); }
  std::string text(int row, int column) const;  // NULL: empty
  int64_t integer(int row, int column) const;
  uint64_t number(int row, int column) const { return static_cast<uint64_t>(integer(row, column)); }
  double real(int row, int column) const;

 private:
  const Libpq* pq_;
  std::unique_ptr<PGresult, decltype(&PQclear)> result_;
};

class PgConnection {
 public:
  static Result<std::unique_ptr<PgConnection>> open(const Libpq& pq, const std::string& url);
  ~PgConnection();
  PgConnection(const PgConnection&) = delete;
  PgConnection& operator=(const PgConnection&) = delete;

  // One statement with its values. `as_bytes`: all columns are text or bytea, and bytea arrives as
  // it is.
  Result<PgRows> run(const char* sql, const std::vector<PgValue>& values, bool as_bytes = false);
  // Several, without values, in one round trip; the last one's rows.
  Result<PgRows> run_all(const char* sql);
  // False: it is of no use any more.
  bool good() const { return !broken_; }
  // Waits for notifications or for `time`; whether there were any, and what they said.
  Result<std::vector<std::string>> notifications(std::chrono::milliseconds time);

 private:
  PgConnection(const Libpq& pq, PGconn* connection) : pq_(pq), connection_(connection) {}
  Result<PgRows> answer(bool sent);
  bool wait(short events, std::chrono::steady_clock::time_point until);
  Error lost(const std::string& doing);

  const Libpq& pq_;
  PGconn* connection_;
  bool broken_ = false;
};

// The address without its password, for messages.
std::string without_password(const Libpq& pq, const std::string& url);

}  // namespace qray::server
