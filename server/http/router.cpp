#include "server/http/router.h"

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

void Router::add(std::string method, std::string_view pattern, RouteHandler handler,
                 std::optional<Scope> needed) {
  const Scope scope = needed.value_or(usual_scope(method));
  routes_.push_back({std::move(method),
                     std::string(pattern),
                     split(pattern),
                     scope,
                     std::move(handler),
                     {},
                     0,
                     {}});
}

void Router::add_stream(std::string method, std::string_view pattern, size_t max_body_bytes,
                        StreamHandler handler, std::optional<Scope> needed) {
  const Scope scope = needed.value_or(usual_scope(method));
  routes_.push_back({std::move(method),
                     std::string(pattern),
                     split(pattern),
                     scope,
                     {},
                     std::move(handler),
                     max_body_bytes,
                     {}});
}

void Router::set_parameters(const std::map<std::string, std::set<std::string>>& names) {
  for (Route& route : routes_) {
    const auto found = names.find(route.method + " " + route.pattern);
    route.parameters = found == names.end() ? std::set<std::string>() : found->second;
  }
}

std::vector<Router::RouteInfo> Router::routes() const {
  std::vector<RouteInfo> infos;
  for (const Route& route : routes_) infos.push_back({route.method, route.pattern, route.needed});
  return infos;
}

Router::Match Router::find(std::string_view method, std::string_view path) const {
  Found found = find_route(method, path);
  Match match;
  match.allow = std::move(found.allow);
  match.id = std::move(found.id);
  if (const Route* route = found.route) {
    if (route->stream) {
      match.stream = &route->stream;
    } else {
      match.handler = &route->handler;
    }
    match.needed = route->needed;
    match.pattern = route->pattern;
    if (route->parameters) match.parameters = &*route->parameters;
  }
  return match;
}

std::optional<size_t> Router::max_body_bytes(std::string_view method, std::string_view path) const {
  const Route* route = find_route(method, path).route;
  if (!route || !route->stream) return std::nullopt;
  return route->max_body_bytes;
}

size_t Router::max_body_bytes() const {
  size_t largest = 0;
  for (const Route& route : routes_) largest = std::max(largest, route.max_body_bytes);
  return largest;
}

Router::Found Router::find_route(std::string_view method, std::string_view path) const {
  const std::vector<std::string> segments = split(path);
  Found match;
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
      return {&route, std::move(id), ""};
    }
    match.allow += (match.allow.empty() ? "" : ", ") + route.method;
  }
  return match;
}

}  // namespace qray::server
