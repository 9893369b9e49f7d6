// Literal routes with at most one captured segment ("/v1/jobs/{id}/tiles"), by plain comparison: no
// regular expression ever sees a client's path. Filled before serving, then const from any thread.
#pragma once

#include <httplib.h>

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/scope.h"

namespace qray::server {

// `id`: what {id} stood for, empty without one.
using RouteHandler =
    std::function<void(const httplib::Request&, httplib::Response&, const std::string& id)>;
// Takes the body as it arrives; what it leaves is passed over.
using StreamHandler = std::function<void(const httplib::Request&, httplib::Response&,
                                         const std::string& id, const httplib::ContentReader&)>;

class Router {
 public:
  // `needed`: of the caller's token; left out, what is usual for the method.
  void add(std::string method, std::string_view pattern, RouteHandler handler,
           std::optional<Scope> needed = {});
  // For bodies too large for memory: up to `max_body_bytes` instead of the server's own limit.
  void add_stream(std::string method, std::string_view pattern, size_t max_body_bytes,
                  StreamHandler handler, std::optional<Scope> needed = {});
  // What queries may name, by method and pattern ("GET /v1/jobs"): all routes that were added get
  // theirs, those that are not named get none. Without this call queries may name anything.
  void set_parameters(const std::map<std::string, std::set<std::string>>& names);
  // For GET paths that no route matches; true when it answered.
  void set_fallback(std::function<bool(const httplib::Request&, httplib::Response&)> fallback) {
    fallback_ = std::move(fallback);
  }

  struct Match {
    const RouteHandler* handler = nullptr;  // at most one of the two
    const StreamHandler* stream = nullptr;
    Scope needed = Scope::kOpen;
    std::string_view pattern;                           // "/v1/jobs/{id}"; empty: no route
    const std::set<std::string>* parameters = nullptr;  // of its query; null: any
    std::string id;
    std::string allow;  // methods of this path, when there are others than the one asked
    bool found() const { return handler || stream; }
  };
  struct RouteInfo {
    std::string method, pattern;
    Scope needed;
  };
  std::vector<RouteInfo> routes() const;
  Match find(std::string_view method, std::string_view path) const;
  // Of the body of a request; none: the server's own limit.
  std::optional<size_t> max_body_bytes(std::string_view method, std::string_view path) const;
  // The largest of them; 0 without any.
  size_t max_body_bytes() const;
  bool fallback(const httplib::Request& req, httplib::Response& res) const {
    return fallback_ && fallback_(req, res);
  }

 private:
  struct Route {
    std::string method, pattern;
    std::vector<std::string> segments;
    Scope needed;
    RouteHandler handler;
    StreamHandler stream;
    size_t max_body_bytes = 0;
    std::optional<std::set<std::string>> parameters;
  };
  struct Found {
    const Route* route = nullptr;
    std::string id, allow;
  };
  Found find_route(std::string_view method, std::string_view path) const;

  std::vector<Route> routes_;
  std::function<bool(const httplib::Request&, httplib::Response&)> fallback_;
};

}  // namespace qray::server
