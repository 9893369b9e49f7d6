#include "server/webhooks/addresses.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>

namespace qray::server {
namespace {

Address address(const std::string& text) {
  Address a{};
  if (text.find(':') == std::string::npos) {
    a.v4.sin_family = AF_INET;
    EXPECT_EQ(::inet_pton(AF_INET, text.c_str(), &a.v4.sin_addr), 1) << text;
  } else {
    a.v6.sin6_family = AF_INET6;
    EXPECT_EQ(::inet_pton(AF_INET6, text.c_str(), &a.v6.sin6_addr), 1) << text;
  }
  return a;
}

TEST(WebhookAddresses, ThoseOfTheInternetArePublic) {
  for (const char* text :
       {"1.1.1.1", "9.255.255.255", "11.0.0.0", "100.63.255.255", "100.128.0.0", "172.15.255.255",
        "172.32.0.0", "192.167.255.255", "198.17.255.255", "198.20.0.0", "223.255.255.255",
        "2606:4700::1111", "2001:4860::8888", "::ffff:1.1.1.1"})
    EXPECT_TRUE(is_public(address(text))) << text;
}

TEST(WebhookAddresses, AllOthersAreNot) {
  for (const char* text : {"0.0.0.0",
                           "0.1.2.3",
                           "10.0.0.1",
                           "100.64.0.1",
                           "100.127.255.255",
                           "127.0.0.1",
                           "127.255.255.255",
                           "169.254.169.254",
                           "172.16.0.1",
                           "172.31.255.255",
                           "192.0.0.8",
                           "192.0.2.1",
                           "192.88.99.1",
                           "192.168.1.1",
                           "198.18.0.1",
                           "198.19.255.255",
                           "198.51.100.1",
                           "203.0.113.1",
                           "224.0.0.1",
                           "255.255.255.255",
                           "::",
                           "::1",
                           "::ffff:127.0.0.1",
                           "::ffff:10.0.0.1",
                           "::127.0.0.1",
                           "64:ff9b::7f00:1",
                           "fe80::1",
                           "fc00::1",
                           "fd12::1",
                           "ff02::1",
                           "2001::1",
                           "2001:db8::1",
                           "2002:7f00:1::",
                           "3fff::1"})
    EXPECT_FALSE(is_public(address(text))) << text;
}

TEST(WebhookAddresses, NumbersAreResolvedWithoutAsking) {
  const auto soon = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto found = resolve("127.0.0.1", 81, soon, {});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(ntohs(found.value().at(0).v4.sin_port), 81);
  // Other spellings of loopback, which some take for names.
  for (const char* text : {"127.1", "2130706433", "0x7f.1"}) {
    const auto other = resolve(text, 81, soon, {});
    EXPECT_TRUE(!other.ok() || !is_public(other.value().at(0))) << text;
  }
}

}  // namespace
}  // namespace qray::server
