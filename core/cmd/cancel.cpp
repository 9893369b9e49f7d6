// qray cancel: ask a server to stop a job.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/service_client.h"

namespace qray::cmd {
namespace {

struct Options {
  std::string id;
  ServerAddress server;
};

Status run(const Options& o) {
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return client.error();
  const Result<proto::JobView> job = client.value()->cancel(o.id);
  if (!job) return job.error();
  std::printf("%s %s\n", job.value().id.c_str(), job.value().state.c_str());
  return {};
}

}  // namespace

void add_cancel(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("cancel", "stop a job");
  sub->add_option("id", o->id, "the job")->required();
  add_server_option(*sub, o->server);
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report_client(s.error());
  });
}

}  // namespace qray::cmd
