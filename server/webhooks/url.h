// The address of a webhook. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace qray::server {

struct WebhookUrl {
  bool tls = false;
  std::string host;  // without the brackets of IPv6
  uint16_t port = 80;
  std::string target = "/";  // path and query
  std::string host_field;    // as the Host field has it
};

constexpr size_t kMaxWebhookUrl = 1024;  // bytes

// "https://example.org:8443/hook?a=b"; http too. No user, no fragment. kInvalid.
Result<WebhookUrl> parse_webhook_url(std::string_view url);

}  // namespace qray::server
