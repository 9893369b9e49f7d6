#include "server/postgres/pg_connection.h"

#include <poll.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace qray::server {
namespace {

using std::chrono::steady_clock;
constexpr std::chrono::seconds kMostAnswer{10};
// The address may say otherwise of those of libpq.
constexpr const char* kDefaults[][2] = {{"connect_timeout", "5"},  {"application_name", "qrayd"},
                                        {"keepalives_idle", "5"},  {"keepalives_interval", "2"},
                                        {"keepalives_count", "3"}, {"tcp_user_timeout", "10000"}};
constexpr const char* kSettings =
    "SET statement_timeout='5s'; SET lock_timeout='3s'; "
    "SET idle_in_transaction_session_timeout='10s'; "
    "SET default_transaction_isolation='read committed'; SET client_min_messages='warning'; "
    "SET client_encoding='UTF8'";

std::string one_line(const char* message) {
  std::string text = message ? message : "";
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text)
    if (c == '\n' || c == '\t') c = ' ';
  return text;
}

}  // namespace

PgValue::PgValue(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", v);
  text_ = text;
}

std::string PgRows::text(int row, int column) const {
  return {pq_->getvalue(result_.get(), row, column),
          static_cast<size_t>(pq_->getlength(result_.get(), row, column))};
}

int64_t PgRows::integer(int row, int column) const {
  const std::string digits = text(row, column);
  int64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

double PgRows::real(int row, int column) const {
  return std::strtod(pq_->getvalue(result_.get(), row, column), nullptr);
}

Result<std::unique_ptr<PgConnection>> PgConnection::open(const Libpq& pq, const std::string& url) {
  std::vector<const char*> names, values;
  for (const auto& [name, value] : kDefaults) {
    names.push_back(name);
    values.push_back(value);
  }
  names.push_back("dbname");
  values.push_back(url.c_str());
  names.push_back(nullptr);
  values.push_back(nullptr);
  std::unique_ptr<PgConnection> made(
      new PgConnection(pq, pq.connect(names.data(), values.data(), /*expand_dbname=*/1)));
  if (!made->connection_ || pq.status(made->connection_) != CONNECTION_OK)
    return Error{
        ErrorCode::kIo,
        "PostgreSQL cannot be reached: " +
            one_line(made->connection_ ? pq.error_message(made->connection_) : "no memory"),
        ""};
  pq.set_notice_processor(
      made->connection_, [](void*, const char*) {}, nullptr);
  pq.set_nonblocking(made->connection_, 1);
  if (Result<PgRows> set = made->run_all(kSettings); !set.ok()) return set.error();
  return made;
}

PgConnection::~PgConnection() {
  if (connection_) pq_.finish(connection_);
}

Error PgConnection::lost(const std::string& doing) {
  broken_ = true;
  const std::string why = one_line(pq_.error_message(connection_));
  return {ErrorCode::kIo, "PostgreSQL: " + doing + (why.empty() ? "" : ": " + why), ""};
}

bool PgConnection::wait(short events, steady_clock::time_point until) {
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - steady_clock::now()).count();
    if (left < 0) return false;
    pollfd fd{pq_.socket(connection_), events, 0};
    const int ready = ::poll(&fd, 1, static_cast<int>(left) + 1);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

Result<PgRows> PgConnection::run(const char* sql, const std::vector<PgValue>& values,
                                 bool as_bytes) {
  std::vector<const char*> texts;
  std::vector<int> sizes, formats;
  for (const PgValue& value : values) {
    texts.push_back(value.text());
    sizes.push_back(value.size());
    formats.push_back(value.binary());
  }
  return answer(pq_.send_query_params(connection_, sql, static_cast<int>(texts.size()), nullptr,
                                      texts.data(), sizes.data(), formats.data(), as_bytes));
}

Result<PgRows> PgConnection::run_all(const char* sql) {
  return answer(pq_.send_query(connection_, sql));
}

Result<PgRows> PgConnection::answer(bool sent) {
  if (!sent) return lost("the statement could not be sent");
  const auto until = steady_clock::now() + kMostAnswer;
  for (int left; (left = pq_.flush(connection_)) != 0;) {
    if (left < 0) return lost("the connection broke");
    if (!wait(POLLIN | POLLOUT, until)) return lost("the statement was not taken in time");
    if (!pq_.consume_input(connection_)) return lost("the connection broke");
  }
  std::optional<PgRows> rows;
  std::optional<Error> failed;
  for (;;) {
    while (pq_.is_busy(connection_)) {
      if (!wait(POLLIN, until)) return lost("there was no answer within 10 s");
      if (!pq_.consume_input(connection_)) return lost("the connection broke");
    }
    PGresult* result = pq_.get_result(connection_);
    if (!result) break;
    PgRows one(pq_, result);
    const ExecStatusType status = pq_.result_status(result);
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) {
      rows = std::move(one);
    } else if (!failed) {
      const char* message = pq_.result_error_field(result, PG_DIAG_MESSAGE_PRIMARY);
      failed = Error{
          ErrorCode::kIo,
          "PostgreSQL: " + one_line(message ? message : pq_.result_error_message(result)), ""};
    }
  }
  if (pq_.status(connection_) != CONNECTION_OK) broken_ = true;
  if (failed) return *failed;
  if (!rows) return lost("no answer");
  return *std::move(rows);
}

Result<std::vector<std::string>> PgConnection::notifications(std::chrono::milliseconds time) {
  const auto until = steady_clock::now() + time;
  std::vector<std::string> all;
  do {
    if (!pq_.consume_input(connection_)) return lost("the connection broke");
    while (PGnotify* one = pq_.notifies(connection_)) {
      all.emplace_back(one->extra);
      pq_.free_memory(one);
    }
  } while (all.empty() && wait(POLLIN, until));
  return all;
}

std::string without_password(const Libpq& pq, const std::string& url) {
  char* why = nullptr;
  PQconninfoOption* options = pq.parse(url.c_str(), &why);
  if (why) pq.free_memory(why);
  if (!options) return "postgresql:";
  std::string text = "postgresql:";
  for (const PQconninfoOption* option = options; option->keyword; ++option)
    if (option->val && *option->val && !std::strstr(option->keyword, "password") &&
        !std::strstr(option->keyword, "passfile"))
      text += std::string(" ") + option->keyword + "=" + option->val;
  pq.free_info(options);
  return text;
}

}  // namespace qray::server
