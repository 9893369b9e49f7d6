// Jobs that ask to run alone: nothing runs beside them, though the server has room for more.
#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

Json long_job(bool alone) {
  return {{"scene", "box"}, {"width", 8}, {"height", 8}, {"samples", 1'000'000}, {"alone", alone}};
}

// Its place in time: {started, ended}, as the server wrote them.
std::pair<std::string, std::string> span_of(TestService& s, const std::string& id) {
  const Json job = s.get("/v1/jobs/" + id);
  return {job["started"], job["ended"]};
}

TEST(Alone, NothingRunsBesideIt) {
  TestService s;
  s.config.jobs_at_once = 3;
  s.start();
  const auto is_queued = [&](const std::string& id) {
    return s.get("/v1/jobs/" + id)["state"] == "queued";
  };
  const std::string before = s.submit(long_job(false));
  s.wait(before, {"learning", "rendering"});
  const std::string alone = s.submit(long_job(true)), after = s.submit(long_job(false));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_TRUE(is_queued(alone));
  s.post("/v1/jobs/" + before + "/cancel", "", 202);
  s.wait(alone, {"learning", "rendering"});
  // Also once it has a state on disk, which is after a second.
  std::this_thread::sleep_for(std::chrono::milliseconds(1800));
  EXPECT_TRUE(is_queued(after));
  s.post("/v1/jobs/" + alone + "/cancel", "", 202);
  s.wait(after, {"learning", "rendering"});
  s.post("/v1/jobs/" + after + "/cancel", "", 202);
  s.wait(after, {"canceled"});
  EXPECT_LE(span_of(s, before).second, span_of(s, alone).first);
  EXPECT_LE(span_of(s, alone).second, span_of(s, after).first);
}

TEST(Alone, SeveralTakeTurns) {
  TestService s;
  s.config.jobs_at_once = 3;
  s.start();
  std::vector<std::pair<std::string, std::string>> spans;
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i)
    ids.push_back(s.submit(
        {{"scene", "box"}, {"width", 8}, {"height", 8}, {"seconds", 0.1}, {"alone", true}}));
  for (const std::string& id : ids) {
    EXPECT_EQ(s.wait_end(id)["state"], "succeeded");
    spans.push_back(span_of(s, id));
  }
  std::sort(spans.begin(), spans.end());
  for (size_t i = 1; i < spans.size(); ++i) EXPECT_LE(spans[i - 1].second, spans[i].first);
}

}  // namespace
}  // namespace qray::server
