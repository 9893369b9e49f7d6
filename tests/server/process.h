// A qrayd child process on a scratch folder: a server, or a worker of one.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <spawn.h>
#include <sys/wait.h>

#include <csignal>

#include "tests/server/test_service.h"
#include "tests/support/places.h"

extern char** environ;

namespace qray::server::test {

class Process {
 public:
  // `limit`: of the system on it, as `ulimit` takes it. `log`: where its log goes; empty: nowhere.
  explicit Process(const Config& config, const std::string& limit = "", bool is_worker = false,
                   const std::string& log = "", int threads = 1) {
    int out[2];
    EXPECT_EQ(::pipe(out), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO,
                                     log.empty() ? "/dev/null" : log.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0644);
    posix_spawn_file_actions_addclose(&actions, out[0]);
    posix_spawn_file_actions_addclose(&actions, out[1]);
    std::string program = qray::test::program("qrayd").string();
    std::vector<std::string> args = {program};
    if (is_worker) args.push_back("worker");
    args.insert(args.end(), {"--port", "0", "--data", config.data, "--scenes", config.scenes,
                             "--web", config.web, "--threads", std::to_string(threads),
                             "--jobs-at-once", std::to_string(config.jobs_at_once)});
    if (!config.store.empty())
      args.insert(args.end(),
                  {"--store", config.store, "--lease-seconds", std::to_string(config.lease_seconds),
                   "--shared-pass-seconds", std::to_string(config.shared_pass_seconds)});
    if (!config.tokens.empty()) args.insert(args.end(), {"--tokens", config.tokens});
    std::vector<char*> argv;
    std::string shell[] = {"/bin/sh", "-c", "ulimit " + limit + " && exec \"$0\" \"$@\""};
    if (!limit.empty())
      for (std::string& word : shell) argv.push_back(word.data());
    for (std::string& arg : args) argv.push_back(arg.data());
    argv.push_back(nullptr);
    EXPECT_EQ(::posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(out[1]);
    char block[256];
    for (ssize_t n; printed_.find('\n') == std::string::npos &&
                    (n = ::read(out[0], block, sizeof block)) > 0;) {
      printed_.append(block, static_cast<size_t>(n));
    }
    ::close(out[0]);
    const size_t colon = printed_.rfind(':');
    if (colon != std::string::npos) port_ = std::atoi(printed_.c_str() + colon + 1);
  }
  ~Process() {
    if (pid_ > 0) end(SIGKILL);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // The exit status as waitpid gives it.
  int end(int signal) {
    ::kill(pid_, signal);
    return wait();
  }
  void send(int signal) const { ::kill(pid_, signal); }
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(pid_, 0), &status, 0);
    return status;
  }
  const std::string& printed() const { return printed_; }
  int port() const { return port_; }
  Json get(const std::string& path) const {
    const auto answer = httplib::Client("127.0.0.1", port_).Get(path);
    EXPECT_TRUE(answer) << path;
    return answer ? Json::parse(answer->body) : Json::object();
  }
  std::string submit(const Json& request) const {
    const auto answer =
        httplib::Client("127.0.0.1", port_).Post("/v1/jobs", request.dump(), "application/json");
    EXPECT_TRUE(answer && answer->status == 202);
    return answer ? Json::parse(answer->body).value("id", "") : "";
  }
  Json wait_state(const std::string& id, const std::string& state) const {
    Json job;
    for (int i = 0; i < 12'000; ++i) {
      job = get("/v1/jobs/" + id);
      if (job["state"] == state) return job;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << job.dump() << " does not become " << state;
    return job;
  }

 private:
  pid_t pid_ = 0;
  std::string printed_;
  int port_ = 0;
};

}  // namespace qray::server::test
