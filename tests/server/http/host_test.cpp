#include "server/http/host.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

TEST(Host, LoopbackIsThisMachineAlone) {
  for (const char* host : {"localhost", "127.0.0.1", "127.8.9.10", "::1", "[::1]"})
    EXPECT_TRUE(is_loopback(host)) << host;
  for (const char* host : {"", "0.0.0.0", "127.evil.example", "127.0.0.1.evil.example", "127.1",
                           "localhost.evil.example", "[::2]", "[", "]", "[]", "::ffff:10.0.0.1"})
    EXPECT_FALSE(is_loopback(host)) << host;
}

TEST(Host, NamesHaveNoPortAndNoCase) {
  const auto name = [](const char* host) {
    httplib::Request req;
    req.set_header("Host", host);
    return host_name(req);
  };
  EXPECT_EQ(name("Name:80"), "name");
  EXPECT_EQ(name("name"), "name");
  EXPECT_EQ(name("[::1]:80"), "[::1]");
  EXPECT_EQ(name("[::1]"), "[::1]");
  EXPECT_EQ(name(""), "");
}

TEST(Host, APageOfAnotherSiteIsForeign) {
  const auto foreign = [](const char* origin) {
    httplib::Request req;
    req.set_header("Host", "qray.example:8080");
    if (*origin) req.set_header("Origin", origin);
    return has_foreign_origin(req);
  };
  EXPECT_FALSE(foreign(""));
  EXPECT_FALSE(foreign("http://qray.example:8080"));
  EXPECT_FALSE(foreign("https://qray.example:8080"));
  for (const char* origin : {"null", "http://qray.example", "http://evil.example:8080"})
    EXPECT_TRUE(foreign(origin)) << origin;
}

}  // namespace
}  // namespace qray::server
