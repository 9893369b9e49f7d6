#include "server/webhooks/url.h"

#include <algorithm>
#include <charconv>

namespace qray::server {
namespace {

constexpr std::string_view kDigits = "0123456789";

Error expected(const char* what) {
  return {ErrorCode::kInvalid, std::string("expected ") + what, "/url"};
}

}  // namespace

Result<WebhookUrl> parse_webhook_url(std::string_view url) {
  if (url.size() > kMaxWebhookUrl) return expected("at most 1024 bytes");
  WebhookUrl out;
  if (url.starts_with("https://")) {
    out.tls = true;
    out.port = 443;
    url.remove_prefix(8);
  } else if (url.starts_with("http://")) {
    url.remove_prefix(7);
  } else {
    return expected("https:// or http://");
  }
  const bool plain = std::all_of(url.begin(), url.end(), [](char c) { return c > ' ' && c < 127; });
  if (!plain || url.find_first_of("#\\") != std::string_view::npos)
    return expected("printable ASCII without spaces, \\ and #");
  const size_t end = std::min(url.find_first_of("/?"), url.size());
  std::string_view host = url.substr(0, end);
  if (end < url.size()) out.target = (url[end] == '?' ? "/" : "") + std::string(url.substr(end));
  if (host.find('@') != std::string_view::npos) return expected("no user before the host's name");
  out.host_field = host;
  if (const size_t colon = host.rfind(':');
      colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos) {
    const std::string_view port = host.substr(colon + 1);
    const auto [stop, error] = std::from_chars(port.data(), port.data() + port.size(), out.port);
    if (port.empty() || port.find_first_not_of(kDigits) != std::string_view::npos ||
        error != std::errc{} || out.port == 0)
      return expected("a port, 1..65535");
    host = host.substr(0, colon);
  }
  const bool v6 = host.starts_with('[') && host.ends_with(']');
  if (v6) host = host.substr(1, host.size() - 2);
  const bool named = !host.empty() && std::all_of(host.begin(), host.end(), [&](unsigned char c) {
    return std::isalnum(c) || c == '-' || c == '.' || c == '_' || (v6 && c == ':');
  });
  if (!named) return expected("a host's name or address");
  out.host = host;
  return out;
}

}  // namespace qray::server
