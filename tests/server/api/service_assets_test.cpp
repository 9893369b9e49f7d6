// Uploads over HTTP: whole, broken, slow, too large.
#include <gtest/gtest.h>

#include "core/base/sha256.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::RawConnection;
using test::sha;
using test::TestService;

class ServiceAssets : public ::testing::Test {
 protected:
  void SetUp() override {
    s_.config.asset_mib = 6;
    s_.config.body_seconds = 1;
    s_.start();
  }
  httplib::Result put(const std::string& name, const std::string& body) const {
    return s_.client().Put("/v1/assets/" + name, body, "application/octet-stream");
  }
  size_t files() const {
    return static_cast<size_t>(
        std::distance(std::filesystem::directory_iterator(s_.config.data / "assets"), {}));
  }
  TestService s_;
};

TEST_F(ServiceAssets, ArePutOnceAndAskedFor) {
  std::string body(5 << 20, 'x');  // more than a JSON body may have
  body[12345] = '\0';
  const std::string name = sha(body);
  EXPECT_EQ(s_.client().Head("/v1/assets/" + name)->status, 404);
  const auto put_new = put(name, body);
  EXPECT_EQ(put_new->status, 201);
  EXPECT_EQ(Json::parse(put_new->body)["sha256"], name);
  EXPECT_EQ(put(name, body)->status, 200);
  EXPECT_EQ(s_.client().Head("/v1/assets/" + name)->status, 200);
  const auto get = s_.client().Get("/v1/assets/" + name);
  EXPECT_EQ(get->status, 405);
  EXPECT_EQ(get->get_header_value("Allow"), "PUT, HEAD");
  EXPECT_EQ(put(sha(""), "")->status, 201);
}

TEST_F(ServiceAssets, WrongOnesAreRefused) {
  const auto wrong = put(sha("a"), "b");
  EXPECT_EQ(wrong->status, 422);
  EXPECT_NE(wrong->body.find(sha("b")), std::string::npos) << wrong->body;
  for (const std::string name : {"abc", "..", "%2e%2e", "A"}) {
    EXPECT_EQ(put(name, "b")->status, 422) << name;
  }
  EXPECT_EQ(put(std::string(64, 'A'), "b")->status, 422);
  EXPECT_EQ(files(), 0u);
}

TEST_F(ServiceAssets, EachRouteHasItsOwnLimit) {
  const auto head_answer = [&](const std::string& line, size_t bytes) {
    RawConnection c(s_.service->port());
    c.send(line + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(bytes) +
           "\r\n\r\n");
    return c.read_all().substr(9, 3);
  };
  const std::string asset = "PUT /v1/assets/" + sha("x");
  EXPECT_EQ(head_answer(asset, (6 << 20) + 1), "413");
  EXPECT_EQ(head_answer("POST /v1/jobs", (4 << 20) + 1), "413");
  EXPECT_EQ(head_answer("PUT /v1/jobs", (4 << 20) + 1), "413");
  EXPECT_EQ(head_answer("POST /v1/assets/" + sha("x"), (4 << 20) + 1), "413");
  EXPECT_EQ(head_answer("POST /v1/jobs?to=/v1/assets/" + sha("x"), (4 << 20) + 1), "413");
}

TEST_F(ServiceAssets, BrokenAndSlowUploadsLeaveNothing) {
  const std::string head = "PUT /v1/assets/" + sha("x") +
                           " HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n";
  {
    RawConnection broken(s_.service->port());
    broken.send(head + std::string(50'000, 'x'));
  }
  RawConnection slow(s_.service->port());
  slow.send(head + "xxx");
  EXPECT_EQ(slow.read_all().substr(9, 3), "400");
  for (int i = 0; i < 1000 && files() > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(put(sha("x"), "x")->status, 201);
}

TEST_F(ServiceAssets, AForeignPageMayNotUpload) {
  const httplib::Headers foreign = {{"Origin", "http://evil.example"}};
  EXPECT_EQ(s_.client().Put("/v1/assets/" + sha("x"), foreign, "x", "text/plain")->status, 403);
  EXPECT_EQ(files(), 0u);
}

TEST_F(ServiceAssets, AFullStoreSaysSo) {
  s_.stop();
  std::filesystem::create_directories(s_.config.data / "assets");
  const auto full = s_.config.data / "assets" / std::string(64, 'a');
  std::ofstream(full).close();
  std::filesystem::resize_file(full, size_t{4} << 30);  // a file of holes
  s_.start();
  const auto answer = put(sha("x"), "x");
  EXPECT_EQ(answer->status, 507);
  EXPECT_NE(answer->body.find("4294967296"), std::string::npos) << answer->body;
}

}  // namespace
}  // namespace qray::server
