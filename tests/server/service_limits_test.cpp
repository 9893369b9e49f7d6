// Options that bound what clients may ask for, as clients meet them.
#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

TEST(ServiceLimits, OfRequests) {
  TestService s;
  s.config.json_mib = 1;
  s.config.json_depth = 4;
  s.config.max_pixels = 1000;
  s.config.max_job_seconds = 10;
  s.start();
  const auto refused = [&](const Json& request) {
    return s.post("/v1/jobs", request.dump(), 422)["errors"][0]["pointer"].get<std::string>();
  };
  EXPECT_EQ(refused({{"scene", "box"}, {"width", 40}, {"height", 40}}), "/width");
  EXPECT_EQ(refused({{"scene", "box"}}), "/width");  // 48 x 40, by itself
  EXPECT_EQ(refused({{"scene", "box"}, {"width", 8}, {"height", 8}, {"seconds", 11}}), "/seconds");
  s.post("/v1/jobs", R"({"scene":[[[[1]]]]})", 400);
  s.post("/v1/scenes", R"({"files":[[[[1]]]]})", 400);
  s.post("/v1/tables/merge", R"({"tables":[[[[1]]]]})", 400);
  s.post("/v1/jobs", std::string(1'100'000, ' '), 413);
  s.submit({{"scene", "box"}, {"width", 8}, {"height", 8}, {"seconds", 0.01}});
}

TEST(ServiceLimits, OfStreams) {
  TestService s;
  s.config.max_streams = 1;
  s.start();
  test::RawConnection first(s.service->port());
  first.send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  first.read_until(": qray");
  s.get("/v1/events", 503);
}

TEST(ServiceLimits, OfTriangles) {
  TestService s;
  s.config.max_triangles = 5;  // the box has 6
  s.start();
  EXPECT_TRUE(s.get("/v1/scenes/box")["width"].is_null());
  s.stop();
  s.config.max_triangles = 6;
  s.start();
  EXPECT_EQ(s.get("/v1/scenes/box")["width"], 48);
}

}  // namespace
}  // namespace qray::server
