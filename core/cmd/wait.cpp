// qray wait: block until a server's job has ended; for scripts.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <thread>

#include "core/base/clock.h"
#include "core/cmd/commands.h"
#include "core/cmd/service_client.h"

namespace qray::cmd {
namespace {

constexpr auto kPollPause = std::chrono::milliseconds(300);

struct WaitOptions {
  std::string id;
  ServerAddress server;
  double timeout_seconds = 0;  // 0: none
};

int run(const WaitOptions& o) {
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return report_client(client.error());
  const SteadyClock clock;
  const double start = clock.seconds();
  for (;;) {
    const Result<proto::JobView> job = client.value()->job(o.id);
    if (!job) return report_client(job.error());
    if (job.value().ended()) return report_end(job.value());
    if (o.timeout_seconds > 0 && clock.seconds() - start > o.timeout_seconds) {
      std::fprintf(stderr, "qray: %s is still %s after %g s\n", o.id.c_str(),
                   job.value().state.c_str(), o.timeout_seconds);
      return kExitNotNow;
    }
    std::this_thread::sleep_for(kPollPause);
  }
}

}  // namespace

void add_wait(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<WaitOptions>();
  CLI::App* sub = app.add_subcommand("wait", "wait until a job has ended, and say how");
  sub->add_option("id", o->id, "the job")->required();
  sub->add_option("--timeout", o->timeout_seconds, "give up after so many seconds (exit code 5)")
      ->check(CLI::PositiveNumber);
  add_server_option(*sub, o->server);
  sub->callback([o, &exit_code] { exit_code = run(*o); });
}

}  // namespace qray::cmd
