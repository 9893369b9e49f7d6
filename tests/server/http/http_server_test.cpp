// Attacks and bad manners, against the server that the service uses.
#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <atomic>

#include "server/http/reply.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::RawConnection;

Router small_router() {
  Router router;
  router.add("GET", "/healthz", [](auto&, auto& res, auto&) { reply_json(res, 200, "{}"); });
  router.add("POST", "/echo",
             [](auto& req, auto& res, auto&) { res.set_content(req.body, "text/plain"); });
  router.add("GET", "/large", [](auto&, auto& res, auto&) {
    res.set_content(std::string(8u << 20, 'a'), "text/plain");
  });
  router.add("GET", "/boom", [](auto&, auto&, auto&) { throw std::runtime_error("secret"); });
  router.add("GET", "/stream", [](auto&, auto& res, auto&) {
    res.set_chunked_content_provider("text/event-stream", [](size_t, httplib::DataSink& sink) {
      std::this_thread::sleep_for(milliseconds(20));
      return sink.write(": x\n\n", 5);
    });
  });
  return router;
}

class HttpServerTest : public ::testing::Test {
 protected:
  void start(const HttpLimits& limits = test::quick_limits()) {
    server_ = std::make_unique<HttpServer>(small_router(), limits);
    Result<int> port = server_->start("127.0.0.1", 0);
    ASSERT_TRUE(port.ok()) << port.error().text();
    port_ = port.value();
  }
  std::string exchange(const std::string& text) const {
    RawConnection c(port_);
    c.send(text);
    return c.read_all();
  }
  void expect_alive() const {
    httplib::Client client("127.0.0.1", port_);
    const auto answer = client.Get("/healthz");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 200);
  }

  std::unique_ptr<HttpServer> server_;
  int port_ = 0;
};

const std::string kClose = "Host: x\r\nConnection: close\r\n";

TEST_F(HttpServerTest, Answers) {
  start();
  httplib::Client client("127.0.0.1", port_);
  client.set_keep_alive(true);
  for (int i = 0; i < 3; ++i) {
    const auto echo = client.Post("/echo", std::string(100'000, 'a'), "text/plain");
    ASSERT_TRUE(echo);
    EXPECT_EQ(echo->body.size(), 100'000u);
    const auto missing = client.Get("/missing");
    ASSERT_TRUE(missing);
    EXPECT_EQ(missing->status, 404);
    EXPECT_EQ(missing->get_header_value("Content-Type"), "application/problem+json");
  }
  EXPECT_EQ(server_->connection_count(), 1u);
}

TEST_F(HttpServerTest, MethodsAndForeignOrigins) {
  start();
  httplib::Client client("127.0.0.1", port_);
  client.set_keep_alive(true);
  const auto wrong = client.Post("/healthz", "some body", "text/plain");
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->status, 405);
  EXPECT_EQ(wrong->get_header_value("Allow"), "GET");
  const httplib::Headers foreign = {{"Origin", "http://evil.example"}};
  const auto refused = client.Post("/echo", foreign, "x", "text/plain");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 403);
  const httplib::Headers own = {{"Origin", "http://127.0.0.1:" + std::to_string(port_)}};
  const auto good = client.Post("/echo", own, "x", "text/plain");
  ASSERT_TRUE(good);
  EXPECT_EQ(good->status, 200);
}

TEST_F(HttpServerTest, RefusedHeadsGetAnAnswer) {
  start();
  const std::pair<std::string, const char*> cases[] = {
      {"nonsense\r\n\r\n", "400"},
      {"GET /" + std::string(5000, 'a') + " HTTP/1.1\r\n" + kClose + "\r\n", "414"},
      {"GET /healthz HTTP/1.1\r\n" + kClose + "A: " + std::string(9000, 'b') + "\r\n\r\n", "431"},
      {"GET /healthz HTTP/1.1\r\n" + kClose + "A: " + std::string(1 << 20, 'b'), "431"},
      {"POST /echo HTTP/1.1\r\n" + kClose + "Transfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n",
       "411"},
      {"POST /echo HTTP/1.1\r\n" + kClose + "Content-Length: 99999999\r\n\r\n", "413"},
      {"POST /echo HTTP/1.1\r\n" + kClose +
           "Content-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc",
       "415"},
      {"GET /healthz HTTP/1.1\r\n" + kClose + "Range: bytes=0-0,0-0,0-0\r\n\r\n", "416"},
  };
  for (const auto& [text, status] : cases) {
    const std::string answer = exchange(text);
    EXPECT_EQ(answer.substr(0, 12), std::string("HTTP/1.1 ") + status) << text.substr(0, 80);
    EXPECT_NE(answer.find("application/problem+json"), std::string::npos);
  }
  expect_alive();
}

TEST_F(HttpServerTest, ExceptionsDoNotLeak) {
  start();
  const std::string answer = exchange("GET /boom HTTP/1.1\r\n" + kClose + "\r\n");
  EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 500");
  EXPECT_EQ(answer.find("secret"), std::string::npos);
  expect_alive();
}

TEST_F(HttpServerTest, AnEndlessChunkedBodyIsNotRead) {
  start();
  RawConnection c(port_);
  c.send("POST /echo HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "10000\r\n" + std::string(0x10000, 'z') + "\r\n";
  int sent = 0;
  while (sent < 2000 && c.send(chunk)) ++sent;
  EXPECT_LT(sent, 2000);  // 130 MB were not taken
  expect_alive();
}

TEST_F(HttpServerTest, SlowHeadsAndBodiesEnd) {
  start();
  const auto begin = steady_clock::now();
  RawConnection head(port_), body(port_);
  head.send("GET /healthz HTT");
  body.send("POST /echo HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\nabc");
  EXPECT_EQ(head.read_all().substr(0, 12), "HTTP/1.1 408");
  body.read_all();
  EXPECT_LT(steady_clock::now() - begin, std::chrono::seconds(10));
  expect_alive();
}

TEST_F(HttpServerTest, OneByteAtATimeIsFine) {
  start();
  RawConnection c(port_);
  for (char byte : "GET /healthz HTTP/1.1\r\n" + kClose + "\r\n") c.send(std::string(1, byte));
  EXPECT_EQ(c.read_all().substr(0, 12), "HTTP/1.1 200");
}

TEST_F(HttpServerTest, PipelinedRequestsAreAnsweredInOrder) {
  start();
  const std::string answers = exchange(
      "POST /echo HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n\r\none"
      "POST /nowhere HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n\r\ntwo"
      "POST /echo HTTP/1.1\r\n" +
      kClose + "Content-Length: 5\r\n\r\nthree");
  const size_t one = answers.find("\r\n\r\none"), missing = answers.find("HTTP/1.1 404"),
               three = answers.find("\r\n\r\nthree");
  ASSERT_NE(three, std::string::npos) << answers;
  EXPECT_LT(one, missing);
  EXPECT_LT(missing, three);
}

TEST_F(HttpServerTest, SilentConnectionsAndStreamsDoNotStarveOthers) {
  start();
  std::vector<RawConnection> silent, streams;
  for (int i = 0; i < 64; ++i) silent.emplace_back(port_);
  for (int i = 0; i < 128; ++i) {
    streams.emplace_back(port_);
    streams.back().send("GET /stream HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  for (RawConnection& s : streams) {
    EXPECT_NE(s.read_until(": x").find("200"), std::string::npos);
  }
  for (int i = 0; i < 64; ++i) expect_alive();
}

TEST_F(HttpServerTest, WhenFullTheOldestIdleConnectionMakesRoom) {
  HttpLimits limits = test::quick_limits();
  limits.max_connections = 8;
  start(limits);
  std::vector<RawConnection> silent;
  for (int i = 0; i < 40; ++i) {
    silent.emplace_back(port_);
    if (i % 8 == 0) expect_alive();
  }
  EXPECT_LE(server_->connection_count(), 8u);
  expect_alive();
}

TEST_F(HttpServerTest, WhenFullUnfinishedBodiesAndUnreadAnswersMakeRoom) {
  HttpLimits limits;  // whose patience with each of these is longer than this test
  limits.max_connections = 8;
  start(limits);
  std::vector<RawConnection> held;
  for (int i = 0; i < 20; ++i) {
    held.emplace_back(port_);
    held.back().send("POST /echo HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\nabc");
  }
  for (int i = 0; i < 10; ++i) expect_alive();
  for (int i = 0; i < 20; ++i) {
    held.emplace_back(port_);
    held.back().send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  for (int i = 0; i < 10; ++i) expect_alive();
  EXPECT_LE(server_->connection_count(), 8u);
}

TEST_F(HttpServerTest, StopsWithOpenStreamsAndIdleConnections) {
  start(HttpLimits{});
  std::vector<RawConnection> open;
  for (int i = 0; i < 20; ++i) open.emplace_back(port_);
  for (int i = 0; i < 20; ++i) {
    open.emplace_back(port_);
    open.back().send("GET /stream HTTP/1.1\r\nHost: x\r\n\r\n");
    open.back().read_until(": x");
  }
  const auto begin = steady_clock::now();
  server_->stop();
  EXPECT_LT(steady_clock::now() - begin, std::chrono::seconds(2));
  EXPECT_EQ(server_->connection_count(), 0u);
}

TEST_F(HttpServerTest, ReadersThatLeaveFreeTheirConnection) {
  start();
  {
    std::vector<RawConnection> streams;
    for (int i = 0; i < 10; ++i) {
      streams.emplace_back(port_);
      streams.back().send("GET /stream HTTP/1.1\r\nHost: x\r\n\r\n");
      streams.back().read_until(": x");
    }
  }
  for (int i = 0; i < 500 && server_->connection_count() > 0; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(server_->connection_count(), 0u);
}

TEST_F(HttpServerTest, ATakenPortIsAnError) {
  start();
  HttpServer other(small_router());
  const Result<int> port = other.start("127.0.0.1", port_);
  ASSERT_FALSE(port.ok());
  EXPECT_NE(port.error().where.find(std::to_string(port_)), std::string::npos);
  EXPECT_FALSE(HttpServer(small_router()).start("not an address", 0).ok());
}

}  // namespace
}  // namespace qray::server
