#include "server/webhooks/url.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

TEST(WebhookUrl, ItsParts) {
  const WebhookUrl plain = parse_webhook_url("http://example.org").value();
  EXPECT_FALSE(plain.tls);
  EXPECT_EQ(plain.host, "example.org");
  EXPECT_EQ(plain.port, 80);
  EXPECT_EQ(plain.target, "/");
  const WebhookUrl full = parse_webhook_url("https://Hooks.example.org:8443/a/b?c=d@e:f").value();
  EXPECT_TRUE(full.tls);
  EXPECT_EQ(full.host, "Hooks.example.org");
  EXPECT_EQ(full.host_field, "Hooks.example.org:8443");
  EXPECT_EQ(full.port, 8443);
  EXPECT_EQ(full.target, "/a/b?c=d@e:f");
  EXPECT_EQ(parse_webhook_url("https://x?y").value().target, "/?y");
  const WebhookUrl v6 = parse_webhook_url("https://[2001:db8::1]/").value();
  EXPECT_EQ(v6.host, "2001:db8::1");
  EXPECT_EQ(v6.host_field, "[2001:db8::1]");
  EXPECT_EQ(v6.port, 443);
  EXPECT_EQ(parse_webhook_url("http://[::1]:81").value().port, 81);
}

TEST(WebhookUrl, WhatIsWrong) {
  for (const std::string url :
       {"", "example.org", "ftp://example.org", "HTTP://example.org", "http://", "http:///path",
        "http://user@example.org", "http://user:pass@example.org/", "http://example.org:0",
        "http://example.org:65536", "http://example.org:", "http://example.org:80x", "http://a b",
        "http://example.org/a b", "http://example.org/\r\nX: y", "http://example.org/#f",
        "http://a\\b", "http://a:b:1", "http://\xc3\xa4.example"}) {
    const Result<WebhookUrl> parsed = parse_webhook_url(url);
    ASSERT_FALSE(parsed.ok()) << url;
    EXPECT_EQ(parsed.error().where, "/url");
  }
  EXPECT_FALSE(parse_webhook_url("http://x/" + std::string(kMaxWebhookUrl, 'a')).ok());
}

}  // namespace
}  // namespace qray::server
