#include "server/http/access.h"

#include <algorithm>

#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr int64_t kSessionSeconds = 12 * 3600;
constexpr size_t kMaxSessions = 1000;
constexpr std::string_view kCookie = "qray_session=";

proto::Problem unknown() {
  return {401, "Not authorized", "expected Authorization: Bearer and a token of this server", {}};
}

std::optional<std::string> bearer_token(const httplib::Request& req) {
  if (!req.has_header("Authorization")) return std::nullopt;
  const std::string value = req.get_header_value("Authorization");
  constexpr std::string_view kScheme = "bearer ";
  const bool bearer = value.size() > kScheme.size() &&
                      std::equal(kScheme.begin(), kScheme.end(), value.begin(), [](char a, char b) {
                        return a == std::tolower(static_cast<unsigned char>(b));
                      });
  return bearer ? value.substr(kScheme.size()) : std::string();
}

// Empty: there is none.
std::string session_secret(const httplib::Request& req) {
  const std::string all = "; " + req.get_header_value("Cookie");
  const size_t at = all.find("; " + std::string(kCookie));
  if (at == std::string::npos) return "";
  const size_t begin = at + 2 + kCookie.size();
  return all.substr(begin, all.find(';', begin) - begin);
}

// Of "Name:80", "name"; of "[::1]:80", "[::1]".
std::string host_name(std::string host) {
  const size_t colon = host.rfind(':');
  if (colon != std::string::npos && host.find(']', colon) == std::string::npos) host.resize(colon);
  for (char& c : host) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return host;
}

void set_cookie(httplib::Response& res, const std::string& secret, int64_t seconds) {
  res.set_header("Set-Cookie",
                 std::string(kCookie) + secret +
                     "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" + std::to_string(seconds));
}

}  // namespace

void Access::add_to(Router& router) {
  router.add(
      "POST", "/v1/session", [this](auto& req, auto& res, auto&) { open(req, res); }, Scope::kOpen);
  router.add(
      "DELETE", "/v1/session", [this](auto& req, auto& res, auto&) { close(req, res); },
      Scope::kOpen);
}

std::optional<proto::Problem> Access::judge(const httplib::Request& req, Scope needed) const {
  if (needed == Scope::kOpen) return std::nullopt;
  if (tokens_.empty()) {
    if (served(req)) return std::nullopt;
    return proto::Problem{
        421,
        "Misdirected request",
        "this server is not called " + req.get_header_value("Host") + " (qrayd --names)",
        {}};
  }
  const std::optional<Scope> scope = scope_of(req);
  if (!scope) return unknown();
  if (*scope >= needed) return std::nullopt;
  return proto::Problem{403,
                        "Not allowed",
                        "expected a token of scope " + std::string(name_of(needed)) + ", got " +
                            std::string(name_of(*scope)),
                        {}};
}

bool Access::served(const httplib::Request& req) const {
  return names_.empty() || std::find(names_.begin(), names_.end(),
                                     host_name(req.get_header_value("Host"))) != names_.end();
}

std::optional<Scope> Access::scope_of(const httplib::Request& req) const {
  if (const auto token = bearer_token(req)) return tokens_.find(*token);
  const std::string secret = session_secret(req);
  if (secret.empty()) return std::nullopt;
  std::lock_guard lock(mutex_);
  const auto session = sessions_.find(sha256(secret));
  if (session == sessions_.end() || session->second.ends_ms <= now_ms_()) return std::nullopt;
  return session->second.scope;
}

std::string Access::start_session(Scope scope) {
  const std::string secret = random_secret();
  std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [now = now_ms_()](const auto& s) { return s.second.ends_ms <= now; });
  if (sessions_.size() >= kMaxSessions) {
    sessions_.erase(std::min_element(
        sessions_.begin(), sessions_.end(),
        [](const auto& a, const auto& b) { return a.second.ends_ms < b.second.ends_ms; }));
  }
  sessions_[sha256(secret)] = {scope, now_ms_() + kSessionSeconds * 1000};
  return secret;
}

void Access::open(const httplib::Request& req, httplib::Response& res) {
  if (tokens_.empty())
    return reply_error(res, {ErrorCode::kConflict, "this server asks for no token", ""});
  std::optional<std::string> token = bearer_token(req);
  if (!token) {
    if (!is_json(req)) return reply_not_json(res);
    auto parsed = proto::parse_session_request(req.body, {});
    if (const auto* problem = std::get_if<proto::Problem>(&parsed))
      return reply_problem(res, *problem);
    token = std::get<std::string>(std::move(parsed));
  }
  const std::optional<Scope> scope = tokens_.find(*token);
  if (!scope) return reply_problem(res, unknown());
  set_cookie(res, start_session(*scope), kSessionSeconds);
  res.status = 204;
}

void Access::close(const httplib::Request& req, httplib::Response& res) {
  const std::string secret = session_secret(req);
  if (!secret.empty()) {
    std::lock_guard lock(mutex_);
    sessions_.erase(sha256(secret));
  }
  set_cookie(res, "", 0);
  res.status = 204;
}

}  // namespace qray::server
