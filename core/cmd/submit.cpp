// qray submit: post a job to a server, with its scene where that is a file here; prints its id.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/render_options.h"
#include "core/cmd/upload.h"

namespace qray::cmd {
namespace {

struct Options {
  RenderOptions render;
  std::string table;
  std::optional<int> priority;
  std::vector<std::string> labels;  // "name:value"
  ServerAddress server;
};

Status run(const Options& o) {
  Result<proto::JobSubmission> submission = make_submission(o.render);
  if (!submission) return submission.error();
  if (!o.table.empty()) submission.value().table = o.table;
  submission.value().priority = o.priority;
  for (const std::string& label : o.labels) {
    const size_t colon = label.find(':');
    if (colon == std::string::npos)
      return Error{ErrorCode::kInvalid, "expected NAME:VALUE, got '" + label + "'", "--label"};
    submission.value().labels[label.substr(0, colon)] = label.substr(colon + 1);
  }
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return client.error();
  std::error_code ec;
  if (std::filesystem::exists(o.render.scene, ec)) {
    Result<std::string> scene = upload_scene(*client.value(), o.render.scene);
    if (!scene) return scene.error();
    submission.value().scene = std::move(scene).value();
  }
  const Result<proto::JobView> job = client.value()->submit(submission.value());
  if (!job) return job.error();
  std::printf("%s\n", job.value().id.c_str());
  return {};
}

}  // namespace

void add_submit(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand(
      "submit",
      "post a job to a server, sending its scene where that is a file or folder here; "
      "prints the job's id");
  add_render_options(*sub, o->render);
  sub->add_option("--table", o->table, "auto (default), none, or a table's id");
  sub->add_option("--priority", o->priority, "-5..5: each step is twice the share of the server");
  sub->add_option("--label", o->labels, "NAME:VALUE, to find the job by; may be given again");
  add_server_option(*sub, o->server);
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report_client(s.error());
  });
}

}  // namespace qray::cmd
