// A client of the HTTP service (docs/api.md), for the subcommands that talk to a server. Blocking;
// one thread. Errors: kIo when there is no server or it breaks off, kBusy when it is full, else
// what it says is wrong.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/cmd/event_reader.h"
#include "proto/client_json.h"
#include "proto/messages.h"

namespace CLI {
class App;
}

namespace qray::cmd {

struct ServerAddress {
  std::string url;    // "http://127.0.0.1:8080"
  std::string token;  // empty: none
};

class ServiceClient {
 public:
  static Result<std::unique_ptr<ServiceClient>> open(const ServerAddress& server);
  ~ServiceClient();
  ServiceClient(const ServiceClient&) = delete;
  ServiceClient& operator=(const ServiceClient&) = delete;

  // Sends the file's `bytes` bytes unless the server has them.
  Status put_asset(const std::string& sha256, const std::filesystem::path& file, uint64_t bytes);
  Result<proto::SceneView> post_scene(const proto::SceneSubmission& submission);
  Result<proto::JobView> submit(const JobRequest& request);
  Result<proto::JobView> job(const std::string& id);
  // `action`: cancel, pause, resume.
  Result<proto::JobView> act(const std::string& id, const std::string& action);
  Result<proto::JobView> extend(const std::string& id, const proto::ExtendRequest& more);
  Result<std::string> log(const std::string& id);
  // `format`: "exr" or "png"; `exposure` in stops, for png.
  Result<Bytes> image(const std::string& id, const std::string& format,
                      const std::string& exposure);
  // Calls `on_event` until it returns false or the stream ends.
  Status events(const std::string& id, const std::string& after,
                const std::function<bool(const ServerEvent&)>& on_event);

 private:
  struct Impl;
  explicit ServiceClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// --server, else the variable QRAY_SERVER, else http://127.0.0.1:8080; --token, else QRAY_TOKEN.
void add_server_option(CLI::App& app, ServerAddress& server);
// As report(), but kExitUnreachable for kIo.
int report_client(const Error& error);
// Says how a job ended, and the exit code that tells a script.
int report_end(const proto::JobView& job);

}  // namespace qray::cmd
