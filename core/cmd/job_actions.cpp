// qray cancel, pause, resume, extend, log: a job on a server.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/service_client.h"

namespace qray::cmd {
namespace {

struct JobActionsOptions {
  std::string id;
  ServerAddress server;
  proto::ExtendRequest more;
};

Status act(const JobActionsOptions& o, const std::string& action) {
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return client.error();
  const Result<proto::JobView> job =
      action == "extend" ? client.value()->extend(o.id, o.more) : client.value()->act(o.id, action);
  if (!job) return job.error();
  std::printf("%s %s\n", job.value().id.c_str(), job.value().state.c_str());
  return {};
}

Status print_log(const JobActionsOptions& o) {
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return client.error();
  const Result<std::string> log = client.value()->log(o.id);
  if (!log) return log.error();
  std::fputs(log.value().c_str(), stdout);
  return {};
}

std::pair<CLI::App*, std::shared_ptr<JobActionsOptions>> add(CLI::App& app, const char* name,
                                                             const char* what) {
  auto o = std::make_shared<JobActionsOptions>();
  CLI::App* sub = app.add_subcommand(name, what);
  sub->add_option("id", o->id, "the job")->required();
  add_server_option(*sub, o->server);
  return {sub, o};
}

}  // namespace

void add_job_actions(CLI::App& app, int& exit_code) {
  for (const auto& [name, what] : {std::pair{"cancel", "stop a job"},
                                   {"pause", "stop a job so that it can go on from where it is"},
                                   {"resume", "go on with a paused job"},
                                   {"extend", "render more onto a job that has succeeded"}}) {
    const auto [sub, o] = add(app, name, what);
    if (std::string(name) == "extend") {
      auto* samples = sub->add_option("--spp", o->more.samples, "samples a pixel more");
      sub->add_option("--seconds", o->more.seconds, "render so much longer")->excludes(samples);
      sub->add_option("--noise", o->more.noise, "until the picture's relative error is that low");
    }
    sub->callback([o = o, action = std::string(name), &exit_code] {
      if (Status s = act(*o, action); !s) exit_code = report_client(s.error());
    });
  }
  const auto [sub, o] = add(app, "log", "what happened to a job");
  sub->callback([o = o, &exit_code] {
    if (Status s = print_log(*o); !s) exit_code = report_client(s.error());
  });
}

}  // namespace qray::cmd
