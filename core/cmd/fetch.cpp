// qray fetch: a job's picture from a server, as far as it is.
#include <CLI/CLI.hpp>

#include "core/base/file.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/render_options.h"
#include "core/cmd/report.h"
#include "core/cmd/service_client.h"

namespace qray::cmd {
namespace {

struct FetchOptions {
  std::string id, out, exposure = "0";
  ServerAddress server;
};

int run(const FetchOptions& o) {
  if (Status s = check_picture_name(o.out); !s) return report(s.error());
  Result<std::unique_ptr<ServiceClient>> client = ServiceClient::open(o.server);
  if (!client) return report_client(client.error());
  const std::string format = std::filesystem::path(o.out).extension().string().substr(1);
  const Result<Bytes> bytes = client.value()->image(o.id, format, o.exposure);
  if (!bytes) return report_client(bytes.error());
  if (Status s = write_file_atomic(o.out, bytes.value()); !s) return report(s.error());
  return kExitOk;
}

}  // namespace

void add_fetch(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<FetchOptions>();
  CLI::App* sub = app.add_subcommand("fetch", "download a job's picture");
  sub->add_option("id", o->id, "the job")->required();
  add_exposure_option(*sub, o->exposure);
  add_server_option(*sub, o->server);
  sub->add_option("-o,--out", o->out, "picture.exr or picture.png")->required();
  sub->callback([o, &exit_code] { exit_code = run(*o); });
}

}  // namespace qray::cmd
