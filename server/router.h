// Literal routes with at most one captured segment ("/v1/jobs/{id}/tiles"), by plain comparison: no
// regular expression ever sees a client's path. Filled before serving, then const from any thread.
#pragma once

#include <httplib.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace qray::server {

// `id`: what {id} stood for, empty without one.
using RouteHandler =
    std::function<void(const httplib::Request&, httplib::Response&, const std::string& id)>;

class Router {
 public:
  void add(std::string method, std::string_view pattern, RouteHandler handler);
  // For GET paths that no route matches; true when it answered.
  void set_fallback(std::function<bool(const httplib::Request&, httplib::Response&)> fallback) {
    fallback_ = std::move(fallback);
  }

  struct Match {
    const RouteHandler* handler = nullptr;
    std::string id;
    std::string allow;  // methods of this path, when there are others than the one asked
  };
  Match find(std::string_view method, std::string_view path) const;
  bool fallback(const httplib::Request& req, httplib::Response& res) const {
    return fallback_ && fallback_(req, res);
  }

 private:
  struct Route {
    std::string method;
    std::vector<std::string> segments;
    RouteHandler handler;
  };
  std::vector<Route> routes_;
  std::function<bool(const httplib::Request&, httplib::Response&)> fallback_;
};

}  // namespace qray::server
