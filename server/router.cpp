#include "server/router.h"

namespace qray::server {
namespace {

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> segments;
  size_t at = 0;
  while (at < path.size()) {
    const size_t end = std::min(path.find('/', at + 1), path.size());
    segments.emplace_back(path.substr(at, end - at));  // with its leading slash
    at = end;
  }
  return segments;
}

}  // namespace

void Router::add(std::string method, std::string_view pattern, RouteHandler handler) {
  routes_.push_back({std::move(method), split(pattern), std::move(handler)});
}

Router::Match Router::find(std::string_view method, std::string_view path) const {
  const std::vector<std::string> segments = split(path);
  Match match;
  for (const Route& route : routes_) {
    if (route.segments.size() != segments.size()) continue;
    std::string id;
    bool same = true;
    for (size_t i = 0; i < segments.size() && same; ++i) {
      if (route.segments[i] == "/{id}") {
        id = segments[i].substr(1);
      } else {
        same = route.segments[i] == segments[i];
      }
    }
    if (!same) continue;
    if (route.method == method || (route.method == "GET" && method == "HEAD")) {
      return {&route.handler, std::move(id), ""};
    }
    match.allow += (match.allow.empty() ? "" : ", ") + route.method;
  }
  return match;
}

}  // namespace qray::server
