// HTTP/1.1 on cpp-httplib 0.11.4's request processing, with its own listener, threads, head check
// and routes: what the stock server leaves open (docs in README.md) is closed here.
// Threads: one per connection runs the handlers; start and stop from one thread.
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "server/http/http_head.h"
#include "server/http/router.h"
#include "server/http/socket_stream.h"

namespace qray::server {

struct HttpLimits {
  HeadLimits head;
  StreamLimits stream;
  size_t max_connections = 512;  // file numbers stay below FD_SETSIZE, which the library needs
  size_t max_requests_per_connection = 1000;
};

// Why a request with its route's scope may not go on; none: it may.
using Gate = std::function<std::optional<proto::Problem>(const httplib::Request&, Scope needed)>;

// A request and its answer, once both are over.
struct Exchange {
  std::string id;  // of the answer's X-Request-Id
  // As sent; empty: the head was refused. A query that names what the route does not know is left
  // out: clients put secrets there by mistake.
  std::string method, target;
  std::string client;  // its address
  std::string user;    // whose token it was; empty: none
  std::string route;   // "/v1/jobs/{id}"; empty: none
  int status = 0;      // 0: the client left before an answer
  double seconds = 0;  // from its head to the answer's last byte
  uint64_t bytes_in = 0, bytes_out = 0;
};

struct HttpHooks {  // any may be empty
  Gate gate;
  std::function<std::string(const httplib::Request&)> user;  // for Exchange::user
  std::function<void(const Exchange&)> exchange;             // called by the connection's thread
};

class HttpServer {
 public:
  explicit HttpServer(Router router, const HttpLimits& limits = {}, HttpHooks hooks = {});
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
