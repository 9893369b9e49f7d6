// What a data folder keeps over the end of one server and the start of the next.
#include <gtest/gtest.h>

#include "core/base/byte_io.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

Json tiny(int samples) {
  return {{"scene", "box"},
          {"width", 32},
          {"height", 32},
          {"samples", samples},
          {"learning_samples", 16}};
}

std::string body_of(const TestService& s, const std::string& path) {
  const auto answer = s.client().Get(path);
  EXPECT_TRUE(answer && answer->status == 200) << path;
  return answer ? answer->body : "";
}

TEST(ServiceRestart, QueuedAndRunningJobsGoOn) {
  TestService s;
  s.start();
  const std::string running = s.submit(tiny(100'000));
  const std::string queued = s.submit(tiny(4));
  s.wait(running, {"rendering"});
  s.stop();

  s.start();
  // The one put back runs again, from the start; it did not use up an attempt.
  s.wait(running, {"rendering"});
  EXPECT_EQ(s.get("/v1/jobs/" + queued)["state"], "queued");
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
  EXPECT_EQ(s.wait_end(running)["state"], "canceled");
  EXPECT_EQ(s.wait_end(queued)["state"], "succeeded");
  EXPECT_EQ(s.submit(tiny(1)), "j000003");
}

TEST(ServiceRestart, PicturesTablesAndRecordsStay) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny(8));
  const Json job = s.wait_end(id);
  const std::string base = "/v1/jobs/" + id;
  const std::string tiles = body_of(s, base + "/tiles?since=0");
  const std::string png = body_of(s, base + "/image.png?exposure=0.5");
  s.stop();

  s.start();
  EXPECT_EQ(s.get(base), job);
  EXPECT_EQ(body_of(s, base + "/tiles?since=0"), tiles);
  EXPECT_EQ(body_of(s, base + "/image.png?exposure=0.5"), png);
  const Json next = s.wait_end(s.submit(tiny(8)));
  EXPECT_EQ(next["table_in"], job["table_out"]);
}

TEST(ServiceRestart, TwoServersOnOneFolderAreRefused) {
  TestService s;
  s.start();
  const Result<std::unique_ptr<Service>> second = Service::start(s.config);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  s.stop();
  s.start();
}

TEST(ServiceRestart, AFullQueueSaysSo) {
  TestService s;
  s.config.max_queued = 2;
  s.start();
  const std::string running = s.submit(tiny(1'000'000));
  s.wait(running, {"rendering"});
  s.submit(tiny(1));
  s.submit(tiny(1));
  const auto full = s.client().Post("/v1/jobs", tiny(1).dump(), "application/json");
  ASSERT_TRUE(full);
  EXPECT_EQ(full->status, 429);
  EXPECT_TRUE(full->has_header("Retry-After"));
  EXPECT_EQ(s.get("/v1/jobs")["jobs"].size(), 3u);
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
}

TEST(ServiceRestart, ATakenPortIsAnErrorAndLeavesTheFolderFree) {
  TestService a, b;
  a.start();
  b.config.port = a.service->port();
  EXPECT_FALSE(Service::start(b.config).ok());
  b.config.port = 0;
  b.start();
}

TEST(ServiceRestart, ATableOverTheServersMemoryIsPassedOver) {
  TestService s;
  s.start();
  Json request = {{"scene", "box"}, {"method", "huang"}, {"width", 48},
                  {"height", 48},   {"samples", 32},     {"grid", 500}};
  const std::string large = s.wait_end(s.submit(request))["table_out"];
  s.stop();
  s.config.table_mib = 1;
  s.start();
  request["seed"] = 2;
  const Json job = s.wait_end(s.submit(request));
  EXPECT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_TRUE(job["table_in"].is_null());
  ASSERT_EQ(job["warnings"].size(), 1u) << job.dump();
  EXPECT_NE(job["warnings"][0].get<std::string>().find("1048576 bytes"), std::string::npos);
  EXPECT_GT(job["stats"]["table_refused"], 0);
  EXPECT_LE(job["stats"]["table_bytes"], 1 << 20);
}

}  // namespace
}  // namespace qray::server
