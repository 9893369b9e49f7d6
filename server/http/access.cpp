#include "server/http/access.h"

#include <algorithm>

#include "server/http/host.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr int64_t kSessionSeconds = 12 * 3600;
constexpr size_t kMaxSessionsOfOne = 100;  // user
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

// Behind a proxy that ends TLS and says so, a browser sends the cookie by TLS alone. Who makes the
// field up changes his own cookie.
void set_cookie(const httplib::Request& req, httplib::Response& res, const std::string& secret,
                int64_t seconds) {
  const bool by_tls = req.get_header_value("X-Forwarded-Proto") == "https";
  res.set_header("Set-Cookie", std::string(kCookie) + secret +
                                   "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" +
                                   std::to_string(seconds) + (by_tls ? "; Secure" : ""));
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
  if (tokens()->empty()) {
    if (served(req)) return std::nullopt;
    return proto::Problem{
        421,
        "Misdirected request",
        "this server is not called " + req.get_header_value("Host") + " (qrayd --names)",
        {}};
  }
  const std::optional<Caller> caller = caller_of(req);
  if (!caller) return unknown();
  if (caller->scope >= needed) return std::nullopt;
  return proto::Problem{403,
                        "Not allowed",
                        "expected a token of scope " + std::string(name_of(needed)) + ", got " +
                            std::string(name_of(caller->scope)),
                        {}};
}

std::shared_ptr<const Tokens> Access::tokens() const {
  std::lock_guard lock(mutex_);
  return tokens_;
}

void Access::replace(Tokens tokens) {
  std::lock_guard lock(mutex_);
  tokens_ = std::make_shared<const Tokens>(std::move(tokens));
  std::erase_if(sessions_, [&](const auto& item) {
    const Session& session = item.second;
    const Tokens::Entry* entry = tokens_->find(session.token);
    return !entry || entry->name != session.caller.user || entry->scope != session.caller.scope;
  });
}

std::string Access::user(const httplib::Request& req) const {
  const std::optional<Caller> caller = caller_of(req);
  return caller ? caller->user : "";
}

bool Access::served(const httplib::Request& req) const {
  if (!names_) return true;
  const std::string name = host_name(req);
  return is_loopback(name) || std::find(names_->begin(), names_->end(), name) != names_->end();
}

std::optional<Access::Caller> Access::caller_of(const httplib::Request& req) const {
  if (const auto token = bearer_token(req)) {
    const std::shared_ptr<const Tokens> tokens = this->tokens();
    const Tokens::Entry* entry = tokens->find(*token);
    return entry ? std::optional(Caller{entry->scope, entry->name}) : std::nullopt;
  }
  const std::string secret = session_secret(req);
  if (secret.empty()) return std::nullopt;
  std::lock_guard lock(mutex_);
  const auto session = sessions_.find(sha256(secret));
  if (session == sessions_.end() || session->second.ends_ms <= now_ms_()) return std::nullopt;
  return session->second.caller;
}

std::string Access::start_session(const Tokens::Entry& token) {
  const std::string secret = random_secret();
  const Caller caller{token.scope, token.name};
  std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [now = now_ms_()](const auto& s) { return s.second.ends_ms <= now; });
  auto oldest = sessions_.end();
  size_t of_user = 0;
  for (auto s = sessions_.begin(); s != sessions_.end(); ++s) {
    if (s->second.caller.user != caller.user) continue;
    ++of_user;
    if (oldest == sessions_.end() || s->second.ends_ms < oldest->second.ends_ms) oldest = s;
  }
  if (of_user >= kMaxSessionsOfOne) sessions_.erase(oldest);
  sessions_[sha256(secret)] = {caller, token.digest, now_ms_() + kSessionSeconds * 1000};
  return secret;
}

void Access::open(const httplib::Request& req, httplib::Response& res) {
  const std::shared_ptr<const Tokens> tokens = this->tokens();
  if (tokens->empty())
    return reply_error(res, {ErrorCode::kConflict, "this server asks for no token", ""});
  std::optional<std::string> token = bearer_token(req);
  if (!token) {
    if (!is_json(req)) return reply_not_json(res);
    auto parsed = proto::parse_session_request(req.body, {});
    if (const auto* problem = std::get_if<proto::Problem>(&parsed))
      return reply_problem(res, *problem);
    token = std::get<std::string>(std::move(parsed));
  }
  const Tokens::Entry* entry = tokens->find(*token);
  if (!entry) return reply_problem(res, unknown());
  set_cookie(req, res, start_session(*entry), kSessionSeconds);
  res.status = 204;
}

void Access::close(const httplib::Request& req, httplib::Response& res) {
  const std::string secret = session_secret(req);
  if (!secret.empty()) {
    std::lock_guard lock(mutex_);
    sessions_.erase(sha256(secret));
  }
  set_cookie(req, res, "", 0);
  res.status = 204;
}

}  // namespace qray::server
