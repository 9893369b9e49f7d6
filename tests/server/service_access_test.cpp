// Tokens, scopes and sessions over HTTP, for every route that there is.
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "server/http/tokens.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

class ServiceAccess : public ::testing::Test {
 protected:
  void SetUp() override {
    s_.config.tokens = s_.scratch / "tokens";
    std::string lines;
    for (const char* scope : {"read", "submit", "admin"})
      lines += std::string(scope) + " " + scope + " " + sha256(token(scope)).hex() + "\n";
    test::write_text(s_.config.tokens, lines);
    s_.start();
  }
  static std::string token(const std::string& scope) { return "token-of-" + scope; }
  httplib::Client with(const httplib::Headers& headers) const {
    httplib::Client client = s_.client();
    client.set_default_headers(headers);
    return client;
  }
  static httplib::Headers bearer(const std::string& token) {
    return {{"Authorization", "Bearer " + token}};
  }
  httplib::Result call(const std::string& method, const std::string& path,
                       const httplib::Headers& headers) const {
    httplib::Client client = with(headers);
    if (method == "GET") return client.Get(path);
    if (method == "HEAD") return client.Head(path);
    if (method == "DELETE") return client.Delete(path);
    if (method == "PATCH") return client.Patch(path, "{}", "application/json");
    if (method == "PUT") return client.Put(path, "x", "application/octet-stream");
    return client.Post(path, "{}", "application/json");
  }
  // Its cookie, as a client sends it back.
  std::string open_session(const std::string& scope) const {
    const auto answer =
        s_.client().Post("/v1/session", Json{{"token", token(scope)}}.dump(), "application/json");
    EXPECT_EQ(answer->status, 204);
    const std::string cookie = answer->get_header_value("Set-Cookie");
    EXPECT_NE(cookie.find("; HttpOnly"), std::string::npos) << cookie;
    EXPECT_NE(cookie.find("; SameSite=Strict"), std::string::npos) << cookie;
    EXPECT_NE(cookie.find("; Path=/;"), std::string::npos) << cookie;
    return cookie.substr(0, cookie.find(';'));
  }

  TestService s_;
};

TEST_F(ServiceAccess, EveryRouteForEveryToken) {
  struct Caller {
    const char* name;
    httplib::Headers headers;
    std::optional<Scope> scope;
  };
  const Caller callers[] = {{"nobody", {}, {}},
                            {"a stranger", bearer("token-of-nobody"), {}},
                            {"another scheme", {{"Authorization", "Basic cmVhZDpyZWFk"}}, {}},
                            {"read", bearer(token("read")), Scope::kRead},
                            {"submit", bearer(token("submit")), Scope::kSubmit},
                            {"admin", bearer(token("admin")), Scope::kAdmin}};
  ASSERT_GT(s_.service->routes().size(), 20u);
  for (const Router::RouteInfo& route : s_.service->routes()) {
    if (route.pattern == "/v1/session") continue;  // judges by itself: below
    std::string path = route.pattern;
    if (const size_t at = path.find("{id}"); at != std::string::npos) path.replace(at, 4, "j9");
    if (path == "/v1/events") path += "?job=j999999";  // an answer rather than a stream
    for (const Caller& caller : callers) {
      const auto answer = call(route.method, path, caller.headers);
      ASSERT_TRUE(answer) << route.method << " " << path;
      const std::string what = route.method + " " + path + " by " + caller.name;
      if (!caller.scope && route.needed != Scope::kOpen) {
        EXPECT_EQ(answer->status, 401) << what;
        EXPECT_EQ(answer->get_header_value("WWW-Authenticate"), "Bearer realm=\"qray\"") << what;
      } else if (caller.scope && *caller.scope < route.needed) {
        EXPECT_EQ(answer->status, 403) << what;
      } else {
        EXPECT_NE(answer->status, 401) << what;
        EXPECT_NE(answer->status, 403) << what;
      }
      EXPECT_FALSE(answer->has_header("Access-Control-Allow-Origin")) << what;
    }
  }
}

TEST_F(ServiceAccess, ThePageAndTheProbesNeedNone) {
  for (const char* path : {"/", "/index.html", "/healthz", "/readyz"})
    EXPECT_EQ(s_.client().Get(path)->status, 200) << path;
}

TEST_F(ServiceAccess, ARefusedBodyIsNotRead) {
  test::RawConnection c(s_.service->port());
  c.send("PUT /v1/assets/" + std::string(64, '0') +
         " HTTP/1.1\r\nHost: x\r\nContent-Length: 60000000\r\n\r\n");
  EXPECT_NE(c.read_until("\r\n").find(" 401 "), std::string::npos);
}

TEST_F(ServiceAccess, ASessionStandsForItsToken) {
  const std::string cookie = open_session("read");
  const httplib::Headers headers{{"Cookie", "other=1; " + cookie + "; more=2"}};
  EXPECT_EQ(call("GET", "/v1/jobs", headers)->status, 200);
  EXPECT_EQ(call("POST", "/v1/jobs", headers)->status, 403);
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", cookie + "0"}})->status, 401);
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", "x" + cookie}})->status, 401);
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", "qray_session="}})->status, 401);
  // A wrong token is not made up for by a session.
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", cookie}, {"Authorization", "Bearer x"}})->status,
            401);

  test::RawConnection stream(s_.service->port());
  stream.send("GET /v1/events HTTP/1.1\r\nHost: x\r\nCookie: " + cookie + "\r\n\r\n");
  EXPECT_NE(stream.read_until(": qray").find("text/event-stream"), std::string::npos);

  const auto closed = call("DELETE", "/v1/session", headers);
  EXPECT_EQ(closed->status, 204);
  EXPECT_NE(closed->get_header_value("Set-Cookie").find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(call("GET", "/v1/jobs", headers)->status, 401);
}

TEST_F(ServiceAccess, OpeningASession) {
  EXPECT_EQ(call("POST", "/v1/session", bearer(token("submit")))->status, 204);
  EXPECT_EQ(call("POST", "/v1/session", bearer("x"))->status, 401);
  s_.post("/v1/session", R"({"token":"x"})", 401);
  EXPECT_EQ(s_.post("/v1/session", R"({"token":7})", 422)["errors"][0]["pointer"], "/token");
  EXPECT_EQ(s_.post("/v1/session", "{}", 422)["errors"][0]["pointer"], "/token");
  EXPECT_EQ(s_.client().Post("/v1/session", "token=x", "text/plain")->status, 415);
  TestService open;
  open.start();
  open.post("/v1/session", R"({"token":"x"})", 409);
}

TEST_F(ServiceAccess, OneUsersSessionsPushOutNoOthers) {
  const std::string admin = open_session("admin"), first = open_session("read");
  std::this_thread::sleep_for(std::chrono::milliseconds(5));  // their age is in milliseconds
  for (int i = 0; i < 100; ++i) open_session("read");
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", first}})->status, 401);
  EXPECT_EQ(call("GET", "/v1/jobs", {{"Cookie", admin}})->status, 200);
}

TEST_F(ServiceAccess, TokensAreReadAgain) {
  const std::string read = open_session("read"), admin = open_session("admin");
  const auto status = [&](const std::string& cookie) {
    return call("GET", "/v1/jobs", {{"Cookie", cookie}})->status;
  };
  const std::string admins = "admin admin " + sha256(token("admin")).hex() + "\n";
  test::write_text(s_.config.tokens, admins + "new read " + sha256(token("new")).hex() + "\n");
  EXPECT_EQ(call("GET", "/v1/jobs", bearer(token("new")))->status, 401);
  s_.service->reload_tokens();
  EXPECT_EQ(call("GET", "/v1/jobs", bearer(token("new")))->status, 200);
  EXPECT_EQ(call("GET", "/v1/jobs", bearer(token("read")))->status, 401);
  EXPECT_EQ(status(read), 401);
  EXPECT_EQ(status(admin), 200);
  // A token that may less now.
  test::write_text(s_.config.tokens, "admin read " + sha256(token("admin")).hex() + "\n");
  s_.service->reload_tokens();
  EXPECT_EQ(status(admin), 401);
  EXPECT_EQ(call("POST", "/v1/jobs", bearer(token("admin")))->status, 403);
  for (const char* wrong : {"admin admin 1234\n", ""}) {
    test::write_text(s_.config.tokens, wrong);
    s_.service->reload_tokens();
    EXPECT_EQ(call("GET", "/v1/jobs", bearer(token("admin")))->status, 200);
  }
}

TEST_F(ServiceAccess, BehindTlsTheCookieIsForTlsAlone) {
  const auto cookie = [&](const httplib::Headers& headers) {
    return with(headers)
        .Post("/v1/session", Json{{"token", token("read")}}.dump(), "application/json")
        ->get_header_value("Set-Cookie");
  };
  EXPECT_NE(cookie({{"X-Forwarded-Proto", "https"}}).find("; Secure"), std::string::npos);
  EXPECT_EQ(cookie({{"X-Forwarded-Proto", "http"}}).find("; Secure"), std::string::npos);
  EXPECT_EQ(cookie({}).find("; Secure"), std::string::npos);
}

TEST_F(ServiceAccess, TheLogSaysWhoAskedAndHoldsNoSecrets) {
  std::ostringstream log;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  const std::string cookie = open_session("read");
  call("GET", "/v1/jobs/j000009?wait=0", bearer(token("submit")));
  call("GET", "/v1/jobs/j000008", {{"Cookie", cookie}});
  call("GET", "/v1/jobs?access_token=" + token("admin"), {});
  call("GET", "/nothing?token=" + token("admin"), {});
  s_.stop();  // all are logged
  spdlog::set_default_logger(before);
  const std::string text = log.str();
  EXPECT_NE(text.find("client=127.0.0.1 user=submit method=GET target=/v1/jobs/j000009?wait=0"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("user=read method=GET target=/v1/jobs/j000008 "), std::string::npos);
  EXPECT_NE(text.find("user=- method=GET target=/v1/jobs?... "), std::string::npos);
  EXPECT_NE(text.find("target=/nothing?... "), std::string::npos);
  EXPECT_EQ(text.find(token("admin")), std::string::npos);
}

TEST(ServiceQueries, WhatARouteDoesNotKnowIsRefused) {
  TestService s;
  s.start();
  const Json problem = s.get("/v1/jobs?lable=a:b", 422);
  EXPECT_NE(problem["detail"].get<std::string>().find("label, limit, q, state, table"),
            std::string::npos);
  s.get("/v1/jobs?label=a:b&wait=1", 422);
  s.get("/v1/scenes?limit=1", 422);
  s.get("/v1/jobs?%ff=1", 422);
  s.post("/v1/jobs?dry=1", R"({"scene":"box"})", 422);
  s.get("/v1/jobs?label=a:b&label=c:d&state=queued&state=failed");
  s.get("/v1/jobs?label=a:b&label=c", 422);
  s.get("/v1/jobs?state=queued&state=done", 422);
  EXPECT_EQ(s.client().Get("/?from=mail")->status, 200);
}

TEST_F(ServiceAccess, PagesOfOtherSitesStayOutside) {
  const std::string cookie = open_session("admin");
  const httplib::Headers foreign{{"Cookie", cookie}, {"Origin", "https://elsewhere.example"}};
  EXPECT_EQ(call("GET", "/v1/jobs", foreign)->status, 403);
  EXPECT_EQ(call("POST", "/v1/jobs", foreign)->status, 403);
  const auto preflight = with(foreign).Options("/v1/jobs");
  EXPECT_EQ(preflight->status, 403);
  for (const auto& [name, value] : preflight->headers)
    EXPECT_FALSE(name.starts_with("Access-Control")) << name;
}

TEST(ServiceNames, ANameThatIsNotServedIsRefusedWithoutTokens) {
  TestService s;
  s.config.names = {"qray.example"};
  s.start();
  const auto status = [&](const std::string& host) {
    const auto answer = s.client().Get("/v1/jobs", {{"Host", host}});
    return answer ? answer->status : 0;
  };
  for (const char* host : {"localhost", "LocalHost:8080", "127.0.0.1:1", "[::1]:8080", "[::1]",
                           "qray.example", "qray.example:443"})
    EXPECT_EQ(status(host), 200) << host;
  for (const char* host : {"rebound.example", "rebound.example:8080", "127.0.0.1.rebound.example",
                           "localhost.rebound.example:80", "[::1].example", "::1"})
    EXPECT_EQ(status(host), 421) << host;
  EXPECT_EQ(s.client().Get("/healthz", {{"Host", "rebound.example"}})->status, 200);
  s.stop();
  s.config.no_auth = true;
  s.start();
  EXPECT_EQ(status("anything.example"), 200);
}

TEST(ServiceStart, OnAnOpenAddressNeedsTokens) {
  TestService s;
  s.config.host = "0.0.0.0";
  const auto refused = Service::start(s.config);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("qrayd token"), std::string::npos);
  s.config.no_auth = true;
  s.start();
  EXPECT_EQ(s.get("/healthz")["status"], "ok");
  s.stop();
  s.config.tokens = s.scratch / "nothing";
  EXPECT_FALSE(Service::start(s.config).ok());
}

}  // namespace
}  // namespace qray::server
