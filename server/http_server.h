// HTTP/1.1 on cpp-httplib 0.11.4's request processing, with its own listener, threads, head check
// and routes: what the stock server leaves open (docs in README.md) is closed here.
// Threads: one per connection runs the handlers; start and stop from one thread.
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "server/http_head.h"
#include "server/router.h"
#include "server/socket_stream.h"

namespace qray::server {

struct HttpLimits {
  HeadLimits head;
  StreamLimits stream;
  size_t max_connections = 512;  // file numbers stay below FD_SETSIZE, which the library needs
  size_t max_requests_per_connection = 1000;
};

class HttpServer {
 public:
  explicit HttpServer(Router router, const HttpLimits& limits = {});
  ~HttpServer();

  // Binds, listens, serves on a thread of its own. Port 0 picks one; the answer is the port.
  Result<int> start(const std::string& host, int port);
  // Ends every connection, event streams too. Handlers that wait must have been told before.
  void stop();
  size_t connection_count() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace qray::server
