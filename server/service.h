// The whole of qrayd but its process: stores, runner and HTTP on one data folder. Start and stop
// from one thread.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "server/http/http_server.h"
#include "server/operation/config.h"

namespace qray::server {

class Service {
 public:
  // Takes the data folder (kConflict: another server has it), recovers its jobs, and serves.
  static Result<std::unique_ptr<Service>> start(const Config& config);
  // As stop().
  ~Service();
  // Ends streams and connections; the running job goes back to the queue of the next start.
  void stop();

  // Reads the file of --tokens again. One that is wrong changes nothing, and the log says why.
  void reload_tokens();

  int port() const;
  const std::vector<Router::RouteInfo>& routes() const;
  size_t stream_count() const;
  size_t connection_count() const;

 private:
  struct Parts;
  explicit Service(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace qray::server
