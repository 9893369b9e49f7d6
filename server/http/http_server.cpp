#include "server/http/http_server.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "server/http/connections.h"
#include "server/http/host.h"
#include "server/http/reply.h"
#include "server/http/tokens.h"

namespace qray::server {
namespace {

constexpr int kBacklog = 512;
constexpr const char* kRequestId = "X-Request-Id";
constexpr size_t kMaxRequestIdBytes = 64;

struct Listener {
  int fd = -1;
  int port = 0;
};

Result<Listener> listen_on(const std::string& host, int port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  const std::string where = host + ":" + std::to_string(port);
  if (const int e = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found)) {
    return Error{ErrorCode::kInvalid, std::string("not an address: ") + gai_strerror(e), where};
  }
  const int fd = ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  bool ok = fd >= 0 && ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
            ::bind(fd, found->ai_addr, found->ai_addrlen) == 0 && ::listen(fd, kBacklog) == 0;
  ::freeaddrinfo(found);
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ok = ok && ::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) == 0;
  if (!ok) {
    const Error error{ErrorCode::kIo, std::string("cannot listen: ") + std::strerror(errno), where};
    if (fd >= 0) ::close(fd);
    return error;
  }
  const in_port_t net_port = bound.ss_family == AF_INET6
                                 ? reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port
                                 : reinterpret_cast<sockaddr_in*>(&bound)->sin_port;
  return Listener{fd, ntohs(net_port)};
}

// The number of the other side's address; empty: it has gone.
std::string peer_address(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  char text[NI_MAXHOST];
  auto* peer = reinterpret_cast<sockaddr*>(&address);
  if (::getpeername(fd, peer, &size) != 0 ||
      ::getnameinfo(peer, size, text, sizeof text, nullptr, 0, NI_NUMERICHOST) != 0)
    return "";
  return text;
}

// Whether the route knows all that the query names.
bool knows_query(const Router::Match& match, const httplib::Request& req) {
  return !match.parameters || std::all_of(req.params.begin(), req.params.end(), [&](const auto& p) {
    return match.parameters->contains(p.first);
  });
}

proto::Problem unknown_parameter(const Router::Match& match) {
  std::string known;
  for (const std::string& name : *match.parameters) known += (known.empty() ? "" : ", ") + name;
  return {
      422, "Unknown parameter", "expected of a query: " + (known.empty() ? "nothing" : known), {}};
}

// As Exchange::target.
std::string logged_target(const httplib::Request& req, const Router::Match& match) {
  const size_t query = req.target.find('?');
  const bool known = match.parameters && knows_query(match, req);
  return known || query == std::string::npos ? req.target : req.target.substr(0, query) + "?...";
}

// A client's own name for its request, when it is short and clean.
bool is_request_id(std::string_view text) {
  return !text.empty() && text.size() <= kMaxRequestIdBytes &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '-' || c == '_' || c == '.';
         });
}

void refuse_raw(SocketStream& stream, const std::string& id, const proto::Problem& problem) {
  const std::string body = proto::problem_to_json(problem);
  stream.write("HTTP/1.1 " + std::to_string(problem.status) + " " + problem.title +
               "\r\nContent-Type: application/problem+json\r\nContent-Length: " +
               std::to_string(body.size()) + "\r\n" + kRequestId + ": " + id +
               "\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n" + body);
}

}  // namespace

class HttpServer::Impl final : public httplib::Server {
 public:
  Impl(Router router, const HttpLimits& limits, HttpHooks hooks)
      : router_(std::move(router)),
        hooks_(std::move(hooks)),
        limits_(limits),
        connections_(limits.max_connections) {
    // The library's one limit; the head check keeps each route's own.
    set_payload_max_length(std::max(limits.head.max_body_bytes, router_.max_body_bytes()));
    set_keep_alive_max_count(limits.max_requests_per_connection);
    set_keep_alive_timeout(
        std::chrono::duration_cast<std::chrono::seconds>(limits.stream.idle).count());
    set_default_headers({{"X-Content-Type-Options", "nosniff"},
                         {"Referrer-Policy", "no-referrer"},
                         {"Cross-Origin-Resource-Policy", "same-origin"},
                         {"Accept-Ranges", "none"}});
    set_post_routing_handler([](const httplib::Request& req, httplib::Response& res) {
      res.set_header(kRequestId, req.get_header_value(kRequestId));
      // The page brings its own.
      if (!res.has_header("Content-Security-Policy"))
        res.set_header("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
    });
    // Whatever has no body is answered before the library's own routing; the others are let through
    // to have their body read, and only when they may.
    set_pre_routing_handler([this](const httplib::Request& req, httplib::Response& res) {
      const Router::Match match = router_.find(req.method, req.path);
      if (refused(req, res, match)) return HandlerResponse::Handled;
      if (req.method == "POST" || req.method == "PUT" || req.method == "PATCH")
        return HandlerResponse::Unhandled;
      (*match.handler)(req, res, match.id);
      return HandlerResponse::Handled;
    });
    const auto with_body = [this](const httplib::Request& req, httplib::Response& res,
                                  const httplib::ContentReader& reader) {
      dispatch_with_body(req, res, reader);
    };
    Post(".*", with_body);
    Put(".*", with_body);
    Patch(".*", with_body);
    set_exception_handler(
        [](const httplib::Request& req, httplib::Response& res, std::exception_ptr e) {
          try {
            std::rethrow_exception(e);
          } catch (const std::exception& what) {
            spdlog::error("request={} {} {}: exception: {}", req.get_header_value(kRequestId),
                          req.method, req.path, what.what());
          } catch (...) {
            spdlog::error("request={} {} {}: unknown exception", req.get_header_value(kRequestId),
                          req.method, req.path);
          }
          reply_problem(res, {500, "Internal error", "", {}});
        });
    set_error_handler([](const httplib::Request&, httplib::Response& res) {
      if (!res.body.empty()) return;
      reply_problem(res, {res.status, res.status == 400 ? "Bad request" : "Refused", "", {}});
    });
  }

  ~Impl() override { stop(); }

  Result<int> start(const std::string& host, int port) {
    Result<Listener> listener = listen_on(host, port);
    if (!listener.ok()) return listener.error();
    svr_sock_ = listener.value().fd;  // the library's streams end when it becomes invalid
    acceptor_ = std::jthread(
        [this, fd = listener.value().fd](std::stop_token stop) { accept_loop(fd, stop); });
    return listener.value().port;
  }

  void stop() {
    const int fd = svr_sock_.exchange(INVALID_SOCKET);
    if (acceptor_.joinable()) {
      acceptor_.request_stop();
      ::shutdown(fd, SHUT_RDWR);  // wakes its poll
      acceptor_.join();
    }
    connections_.stop();
    if (fd != INVALID_SOCKET) ::close(fd);
  }

  size_t connection_count() const { return connections_.count(); }

 private:
  // True: it was answered, by a file of the page or by why it may not go on.
  bool refused(const httplib::Request& req, httplib::Response& res, const Router::Match& match) {
    std::optional<proto::Problem> problem;
    if (has_foreign_origin(req)) {
      problem = proto::Problem{403, "Foreign origin", "a page of another site asked", {}};
    } else if (match.found()) {
      if (hooks_.gate) problem = hooks_.gate(req, match.needed);
      if (!problem && !knows_query(match, req)) problem = unknown_parameter(match);
    } else if (!match.allow.empty()) {
      res.set_header("Allow", match.allow);
      problem = proto::Problem{405, "Method not allowed", "expected " + match.allow, {}};
    } else {
      const bool reads = req.method == "GET" || req.method == "HEAD";
      if (reads && router_.fallback(req, res)) return true;
      problem = proto::Problem{404, "Not found", "no such address", {}};
    }
    if (problem) reply_problem(res, *problem);
    return problem.has_value();
  }

  void dispatch_with_body(const httplib::Request& req, httplib::Response& res,
                          const httplib::ContentReader& reader) {
    const Router::Match match = router_.find(req.method, req.path);
    if (match.stream) return (*match.stream)(req, res, match.id, reader);
    httplib::Request whole = req;
    const bool arrived = reader([&](const char* data, size_t size) {
      whole.body.append(data, size);
      return true;
    });
    if (!arrived) return reply_problem(res, {400, "Bad request", "the body did not arrive", {}});
    (*match.handler)(whole, res, match.id);
  }

  void accept_loop(int listener, std::stop_token stop) {
    while (!stop.stop_requested()) {
      pollfd p{listener, POLLIN, 0};
      if (::poll(&p, 1, 1000) <= 0 || stop.stop_requested()) continue;
      const int fd = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      if (fd < 0) {
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        continue;
      }
      const int on = 1;
      ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // Nagle costs 43 ms an answer
      connections_.start(fd, [this, fd](uint64_t id) { serve(fd, id); });
    }
  }

  void serve(int fd, uint64_t id) {
    try {
      SocketStream stream(fd, limits_.stream,
                          [this, id](bool stalled) { connections_.set_stalled(id, stalled); });
      const std::string client = peer_address(fd);
      for (size_t n = 1; n <= limits_.max_requests_per_connection; ++n) {
        connections_.set_idle(id, true);
        if (!serve_one(stream, client, id, n == limits_.max_requests_per_connection)) break;
      }
      if (!connections_.stopping()) stream.linger(std::chrono::milliseconds(300));
    } catch (const std::exception& e) {
      spdlog::error("connection ended by an exception: {}", e.what());
    }
  }

  // False: the connection is over.
  bool serve_one(SocketStream& stream, const std::string& client, uint64_t id, bool last) {
    std::string head;
    const SocketStream::HeadRead read = stream.read_head(limits_.head.max_head_bytes, head);
    if (read == SocketStream::HeadRead::kClosed) return false;
    connections_.set_idle(id, false);
    const auto begin = std::chrono::steady_clock::now();
    Exchange exchange;
    exchange.id = random_secret().substr(0, 16);
    exchange.client = client;
    bool goes_on = false;
    auto judged = judge_head(read, head);
    if (const proto::Problem* problem = std::get_if<proto::Problem>(&judged)) {
      refuse_raw(stream, exchange.id, *problem);
    } else {
      goes_on = process(stream, std::get<AcceptedHead>(std::move(judged)), last, exchange);
    }
    exchange.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    exchange.status = stream.answer_status();
    exchange.bytes_in = stream.received_bytes();
    exchange.bytes_out = stream.sent_bytes();
    if (hooks_.exchange) hooks_.exchange(exchange);
    return goes_on;
  }

  std::variant<AcceptedHead, proto::Problem> judge_head(SocketStream::HeadRead read,
                                                        std::string_view head) const {
    if (read == SocketStream::HeadRead::kTimeout)
      return proto::Problem{408, "Request timeout", "the head did not arrive in time", {}};
    if (read == SocketStream::HeadRead::kTooLarge)
      return proto::Problem{431,
                            "Header fields too large",
                            "expected at most " + std::to_string(limits_.head.max_head_bytes) +
                                " bytes before the empty line",
                            {}};
    return check_head(head, limits_.head, body_limit_);
  }

  bool process(SocketStream& stream, AcceptedHead accepted, bool last, Exchange& exchange) {
    const bool close = last || accepted.close;
    stream.begin(std::move(accepted.text), accepted.body_bytes);
    bool closed = false;
    const bool ok = process_request(stream, close, closed, [&](httplib::Request& req) {
      const std::string given = req.get_header_value(kRequestId);
      if (is_request_id(given)) exchange.id = given;
      req.headers.erase(kRequestId);
      req.set_header(kRequestId, exchange.id);
      exchange.method = req.method;
      const Router::Match match = router_.find(req.method, req.path);
      exchange.target = logged_target(req, match);
      exchange.route = match.pattern;
      if (hooks_.user) exchange.user = hooks_.user(req);
    });
    return ok && !close && !closed && stream.skip_rest();
  }

  Router router_;
  HttpHooks hooks_;
  HttpLimits limits_;
  const BodyLimit body_limit_ = [this](std::string_view method, std::string_view path) {
    return router_.max_body_bytes(method, path).value_or(limits_.head.max_body_bytes);
  };
  Connections connections_;
  std::jthread acceptor_;
};

HttpServer::HttpServer(Router router, const HttpLimits& limits, HttpHooks hooks)
    : impl_(std::make_unique<Impl>(std::move(router), limits, std::move(hooks))) {}

HttpServer::~HttpServer() = default;

Result<int> HttpServer::start(const std::string& host, int port) {
  return impl_->start(host, port);
}

void HttpServer::stop() { impl_->stop(); }

size_t HttpServer::connection_count() const { return impl_->connection_count(); }

}  // namespace qray::server
