// A server in a child process whose file changes may be made to fail, and what its clients were
// told: by that it is judged after it came up again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "tests/crash/faults.h"
#include "tests/server/test_service.h"
#include "tests/support/postgres_server.h"

namespace qray::server::test {

class ChildServer {
 public:
  // Waits until it serves, or has ended.
  explicit ChildServer(const Config& config);
  ~ChildServer();  // kills it
  ChildServer(const ChildServer&) = delete;
  ChildServer& operator=(const ChildServer&) = delete;

  bool alive();
  int port() const { return port_; }
  // An answer's status and JSON; status 0: none came.
  struct Answer {
    int status = 0;
    Json json;
    std::string body;
    bool yes() const { return status / 100 == 2; }
  };
  Answer call(const std::string& method, const std::string& path, const std::string& body = "",
              const std::string& type = "application/json");
  Answer get(const std::string& path) { return call("GET", path); }
  Answer post(const std::string& path, const Json& body) {
    return call("POST", path, body.is_null() ? "" : body.dump());
  }
  // Until the job is in one of these states ("gone": it was deleted): the state; empty: the server
  // ended, or time did.
  std::string wait(const std::string& job, const std::set<std::string>& states,
                   std::chrono::milliseconds most = std::chrono::seconds(20));
  // As by SIGTERM; false: it does not end in time.
  bool stop();

 private:
  pid_t pid_ = 0;
  int port_ = 0;
};

// What must be so at the end. Of what was asked and not answered either may be.
struct Model {
  enum class Is { kThere, kMaybe, kGone };
  struct JobWanted {
    Is is = Is::kThere;
    std::set<std::string> ends = {"succeeded"};  // one of these
    std::optional<std::string> picture;          // of it, when it succeeded
  };
  std::map<std::string, JobWanted> jobs;
  size_t unknown_jobs = 0;  // asked for, without an answer
  std::map<std::string, Is> tables, scenes, weights, webhooks;
  bool more_tables = false;                             // than those
  std::map<std::string, std::set<std::string>> titles;  // that a scene may have
  size_t waiting = 0;                                   // ends that each webhook is to be told of
  std::string file;                                     // that is sent
};

struct Operation {
  const char* name;
  // Makes the data folder, with a server that nothing befalls.
  std::function<void(ChildServer&, Model&)> prepare;
  // What is tried: arms the plan (`arm`) when it begins.
  std::function<void(ChildServer&, Model&, const std::function<void()>& arm)> act;
  bool at_start = false;  // the start of the server is what is tried; `act` comes after
  double keep_days = 0;
};

// Where the server's records are; null: in SQLite.
using Postgres = qray::test::PostgresServer*;

// The changes that the operation makes undisturbed.
int64_t count_changes(const Operation& operation, Postgres postgres);
// One trial; what is wrong is a failure of the test that names operation, fault and k.
void try_fault(const Operation& operation, Postgres postgres, qray::test::Fault fault, int64_t k);

}  // namespace qray::server::test
