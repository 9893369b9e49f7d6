#include "server/http/http_head.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

int status_of(const std::string& head, const HeadLimits& limits = {}) {
  const auto checked = check_head(head, limits);
  const auto* problem = std::get_if<proto::Problem>(&checked);
  return problem ? problem->status : 0;
}

AcceptedHead accepted(const std::string& head) {
  auto checked = check_head(head, {});
  if (const auto* problem = std::get_if<proto::Problem>(&checked)) {
    ADD_FAILURE() << head << problem->status << problem->title;
    return {};
  }
  return std::get<AcceptedHead>(checked);
}

TEST(HttpHead, PassesOnWhatIsGood) {
  const std::string head = "GET /a?b=c HTTP/1.1\r\nHost: x\r\nLast-Event-ID: 7\r\n\r\n";
  const AcceptedHead a = accepted(head);
  EXPECT_EQ(a.text, head);
  EXPECT_EQ(a.body_bytes, 0u);
  EXPECT_FALSE(a.close);
}

TEST(HttpHead, KeepsFromTheParserWhatItNeedNotKnow) {
  const AcceptedHead a = accepted(
      "GET / HTTP/1.1\r\nHost: x\r\nRange: bytes=0-1\r\nAccept-Encoding: br\r\n"
      "remote_addr: 1.2.3.4\r\nqray-range: bytes=5-6\r\n\r\n");
  EXPECT_EQ(a.text, "GET / HTTP/1.1\r\nHost: x\r\nQray-Range: bytes=0-1\r\n\r\n");
}

TEST(HttpHead, TellsHandlersWhetherTheClientTakesGzip) {
  const std::pair<std::string, bool> cases[] = {
      {"Accept-Encoding: gzip", true},
      {"Accept-Encoding: br, x-gzip;q=0.5, *;q=0", true},
      {"ACCEPT-ENCODING: deflate , GZip ; q=0.001", true},
      {"Accept-Encoding: br\r\nAccept-Encoding: gzip", true},
      {"Accept-Encoding: br, *", true},
      {"Accept-Encoding: *;q=0.1, gzip;q=0", false},
      {"Accept-Encoding: gzip;q=0", false},
      {"Accept-Encoding: gzip;q=0.000, identity", false},
      {"Accept-Encoding: gzip; Q=0.0", false},
      {"Accept-Encoding: br;q=1, deflate", false},
      {"Accept-Encoding: gzipped", false},
      {"Accept-Encoding:", false},
      {"Accept-Encoding: ,;=,;q=,", false},
      {"User-Agent: gzip", false},
      {std::string(kAcceptsGzip) + ": 1", false},
      {"qray-accepts-gzip: 1", false},
  };
  for (const auto& [field, takes] : cases) {
    const AcceptedHead a = accepted("GET / HTTP/1.1\r\nHost: x\r\n" + field + "\r\n\r\n");
    const size_t at = a.text.find(std::string("\r\n") + kAcceptsGzip + ": 1\r\n");
    EXPECT_EQ(at != std::string::npos, takes) << field << "\n" << a.text;
    EXPECT_EQ(a.text.find("Accept-Encoding"), std::string::npos) << a.text;
    EXPECT_TRUE(a.text.ends_with("\r\n\r\n")) << a.text;
  }
}

TEST(HttpHead, BodyAndConnection) {
  EXPECT_EQ(accepted("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 12\r\n\r\n").body_bytes, 12u);
  const AcceptedHead none = accepted("POST / HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(none.body_bytes, 0u);
  EXPECT_NE(none.text.find("Content-Length: 0\r\n"), std::string::npos);
  EXPECT_TRUE(accepted("GET / HTTP/1.1\r\nHost: x\r\nConnection: Close\r\n\r\n").close);
  EXPECT_TRUE(accepted("GET / HTTP/1.0\r\n\r\n").close);
  EXPECT_FALSE(accepted("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n").close);
}

TEST(HttpHead, Refuses) {
  const std::string get = "GET / HTTP/1.1\r\nHost: x\r\n", post = "POST / HTTP/1.1\r\nHost: x\r\n";
  const std::pair<std::string, int> cases[] = {
      {"\r\n", 400},
      {"GET\r\n\r\n", 400},
      {"GET / \r\n\r\n", 505},
      {"GET  / HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET http://a/ HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"G\x01T / HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /\tb HTTP/1.1\r\nHost: x\r\n\r\n", 0},  // a tab in a path harms nobody
      {"GET / HTTP/2.0\r\nHost: x\r\n\r\n", 505},
      {"PRI * HTTP/2.0\r\n\r\n", 400},
      {"BREW / HTTP/1.1\r\nHost: x\r\n\r\n", 501},
      {"CONNECT / HTTP/1.1\r\nHost: x\r\n\r\n", 501},
      {"GET / HTTP/1.1\r\n\r\n", 400},
      {get + "Host: y\r\n\r\n", 400},
      {get + "no colon\r\n\r\n", 400},
      {get + " folded: line\r\n\r\n", 400},
      {get + "Name : v\r\n\r\n", 400},
      {get + ": v\r\n\r\n", 400},
      {get + "A: b\rc\r\n\r\n", 400},
      {get + std::string("A: b\0c\r\n\r\n", 10), 400},
      {get + "A: b\nc\r\n\r\n", 400},
      {get + "Content-Length: 5\r\n\r\n", 400},
      {get + "Range: bytes=0-1,2-3\r\n\r\n", 416},
      {post + "Transfer-Encoding: chunked\r\n\r\n", 411},
      {post + "transfer-encoding: identity\r\nContent-Length: 1\r\n\r\n", 411},
      {post + "Content-Encoding: gzip\r\nContent-Length: 1\r\n\r\n", 415},
      {post + "Content-Length: 1\r\nContent-Length: 1\r\n\r\n", 400},
      {post + "Content-Length: 1, 1\r\n\r\n", 400},
      {post + "Content-Length: -1\r\n\r\n", 400},
      {post + "Content-Length: +1\r\n\r\n", 400},
      {post + "Content-Length: 0x10\r\n\r\n", 400},
      {post + "Content-Length:\r\n\r\n", 400},
      {post + "Content-Length: 4194305\r\n\r\n", 413},
      {post + "Content-Length: 99999999999999999999999\r\n\r\n", 413},
      {post + "Content-Type: Multipart/form-data; boundary=x\r\nContent-Length: 1\r\n\r\n", 415},
      {post + "Content-Type: multipart/mixed\r\n\r\n", 415},
      {"GET /" + std::string(1100, 'a') + " HTTP/1.1\r\nHost: x\r\n\r\n", 414},
      {get + "A: " + std::string(5000, 'b') + "\r\n\r\n", 431},
  };
  for (const auto& [head, status] : cases) EXPECT_EQ(status_of(head), status) << head;
}

TEST(HttpHead, TooManyFields) {
  std::string head = "GET / HTTP/1.1\r\nHost: x\r\n";
  for (int i = 0; i < 100; ++i) head += "A: b\r\n";
  EXPECT_EQ(status_of(head + "\r\n"), 431);
}

}  // namespace
}  // namespace qray::server
