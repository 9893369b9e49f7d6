// qrayd: starts the service, says where, and waits for SIGTERM or SIGINT; at SIGHUP it reads the
// tokens again. `qrayd worker`: runs jobs of a store that it shares, until a signal or until it is
// drained. Or reads one upload for the qrayd that started it, or makes a token.
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>

#include "core/base/installed.h"
#include "server/http/tokens.h"
#include "server/imports/check_scene.h"
#include "server/operation/log_format.h"
#include "server/operation/process_limits.h"
#include "server/service.h"
#include "server/worker.h"

namespace {

using namespace qray;

// What jobs leave behind in the pools goes back to the system.
constexpr timespec kBetweenTrims{60, 0};
constexpr timespec kBetweenLooks{0, 200'000'000};  // whether a worker is drained

int run_service(const server::Config& config, const sigset_t& ends) {
  Result<std::unique_ptr<server::Service>> service = server::Service::start(config);
  if (!service.ok()) {
    spdlog::error("{}", service.error().text());
    return 1;
  }
  if (config.tokens.empty() && config.no_auth) {
    spdlog::warn("listening on {} without tokens: whoever reaches it can use this server",
                 config.host);
  }
  const bool v6 = config.host.find(':') != std::string::npos;
  std::printf("qrayd listening on http://%s%s%s:%d\n", v6 ? "[" : "", config.host.c_str(),
              v6 ? "]" : "", service.value()->port());
  std::fflush(stdout);
  for (int signal;
       (signal = sigtimedwait(&ends, nullptr, &kBetweenTrims)) < 0 || signal == SIGHUP;) {
    if (signal == SIGHUP) {
      service.value()->reload_tokens();
    } else {
      malloc_trim(0);
    }
  }
  spdlog::info("stopping");
  service.value()->stop();
  return 0;
}

int run_worker(const server::Config& config, const sigset_t& ends) {
  Result<std::unique_ptr<server::Worker>> worker = server::Worker::start(config);
  if (!worker.ok()) {
    spdlog::error("{}", worker.error().text());
    return 1;
  }
  std::printf("qrayd worker takes jobs\n");
  std::fflush(stdout);
  for (int looks = 0; sigtimedwait(&ends, nullptr, &kBetweenLooks) < 0; ++looks) {
    if (worker.value()->is_drained()) break;
    if (looks % 300 == 299) malloc_trim(0);
  }
  spdlog::info(worker.value()->is_drained() ? "drained" : "stopping");
  worker.value()->stop();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  run_program_of_processor(argv);
  if (const auto check = server::CheckScene::parse(argc, argv)) return server::check_scene(*check);
  if (const auto code = server::token_command(argc, argv)) return *code;
  const bool is_worker = argc > 1 && std::string_view(argv[1]) == "worker";
  const server::ParsedConfig parsed =
      is_worker ? server::parse_config(argc - 1, argv + 1) : server::parse_config(argc, argv);
  if (!parsed.config) return parsed.exit_code;
  server::Config config = *parsed.config;
  server::set_up_log(config.log_format, config.log_level);
  config.max_connections = server::connections_within_limits(config.max_connections);

  std::string options;
  for (const std::string& option : parsed.effective) options += " " + option;
  spdlog::info("qrayd{} {} starts with{}", is_worker ? " worker" : "", version_for_processor(),
               options);

  // Hundreds of threads that come and go leave memory in each pool that the allocator has.
  constexpr int kPools = 4;
  mallopt(M_ARENA_MAX, kPools);

  // Blocked before any thread starts, so that only the waits above see them.
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  if (!config.tokens.empty()) sigaddset(&ends, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  server::survive_limits();
  return is_worker ? run_worker(config, ends) : run_service(config, ends);
}
