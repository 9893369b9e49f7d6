#include "server/api/handlers_webhooks.h"

#include <charconv>

#include "server/http/query.h"
#include "server/http/reply.h"
#include "server/http/tokens.h"
#include "server/webhooks/url.h"

namespace qray::server {
namespace {

proto::WebhookInfo info_of(const Webhook& webhook) {
  return {"w" + std::to_string(webhook.id), webhook.url, webhook.created_ms, webhook.failures,
          webhook.waiting};
}

std::optional<uint64_t> parse_id(const std::string& text) {
  uint64_t id = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 1, end, id);
  if (!text.starts_with('w') || error != std::errc{} || stop != end) return {};
  return id;
}

}  // namespace

// Their addresses may hold what only admins should know.
void WebhookHandlers::add_to(Router& router) {
  router.add(
      "POST", "/v1/webhooks", [this](auto& req, auto& res, auto&) { add(req, res); },
      Scope::kAdmin);
  router.add(
      "GET", "/v1/webhooks", [this](auto&, auto& res, auto&) { list(res); }, Scope::kAdmin);
  router.add("DELETE", "/v1/webhooks/{id}",
             [this](auto&, auto& res, auto& id) { remove(res, id); });
}

void WebhookHandlers::add(const httplib::Request& req, httplib::Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  const auto parsed = proto::parse_webhook_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed))
    return reply_problem(res, *problem);
  const auto& url = std::get<std::string>(parsed);
  if (const auto good = parse_webhook_url(url); !good.ok()) return reply_error(res, good.error());
  const Result<Webhook> added = webhooks_.add(url, random_secret());
  if (!added.ok()) return reply_error(res, added.error());
  reply_json(res, 201, proto::webhook_to_json(info_of(added.value()), added.value().secret));
}

void WebhookHandlers::list(httplib::Response& res) const {
  const Result<std::vector<Webhook>> webhooks = webhooks_.list();
  if (!webhooks.ok()) return reply_error(res, webhooks.error());
  std::vector<proto::WebhookInfo> infos;
  for (const Webhook& webhook : webhooks.value()) infos.push_back(info_of(webhook));
  reply_json(res, 200, proto::webhook_list_to_json(infos));
}

void WebhookHandlers::remove(httplib::Response& res, const std::string& id) {
  const std::optional<uint64_t> number = parse_id(id);
  if (!number) return reply_error(res, {ErrorCode::kNotFound, "no such webhook", ""});
  if (Status s = webhooks_.remove(*number); !s.ok()) return reply_error(res, s.error());
  res.status = 204;
}

}  // namespace qray::server
