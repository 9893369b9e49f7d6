// qray submit: post a job to a server, with its scene where that is a file here; prints its id.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/render_options.h"
#include "core/cmd/upload.h"

namespace qray::cmd {
namespace {

struct SubmitOptions {
  RenderOptions render;
  ServerAddress server;
};

Status run(const SubmitOptions& o) {
  Result<JobRequest> request = make_request(o.render, kSubmit);
  if (!request) return request.error();
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return client.error();
  std::error_code ec;
  if (std::filesystem::exists(o.render.scene, ec)) {
    Result<std::string> scene = upload_scene(*client.value(), o.render.scene);
    if (!scene) return scene.error();
    request.value().set(field::kScene, std::move(scene).value());
  }
  const Result<proto::JobView> job = client.value()->submit(request.value());
  if (!job) return job.error();
  std::printf("%s\n", job.value().id.c_str());
  return {};
}

}  // namespace

void add_submit(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<SubmitOptions>();
  CLI::App* sub = app.add_subcommand(
      "submit",
      "post a job to a server, sending its scene where that is a file or folder here; "
      "prints the job's id");
  add_render_options(*sub, o->render, kSubmit);
  add_server_option(*sub, o->server);
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report_client(s.error());
  });
}

}  // namespace qray::cmd
