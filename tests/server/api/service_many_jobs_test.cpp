// Jobs changed after they were posted, found by time, and deleted many at a time.
#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

class ServiceManyJobs : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  static Json tiny(const Json& changes = Json::object()) {
    Json request = {
        {"scene", "box"}, {"width", 16}, {"height", 16}, {"method", "none"}, {"samples", 1}};
    request.update(changes);
    return request;
  }
  // Runs until it is canceled; those behind it wait.
  std::string block() {
    const std::string id = s_.submit(tiny({{"samples", 1'000'000}}));
    s_.wait(id, {"rendering"});
    return id;
  }
  Json patch(const std::string& id, const Json& body, int status) const {
    const auto answer = s_.client().Patch("/v1/jobs/" + id, body.dump(), "application/json");
    EXPECT_EQ(answer->status, status) << answer->body;
    return Json::parse(answer->body);
  }
  Json remove(const std::string& query, int status = 200) const {
    const auto answer = s_.client().Delete("/v1/jobs" + query);
    EXPECT_EQ(answer->status, status) << answer->body;
    return Json::parse(answer->body);
  }
  TestService s_;
};

TEST_F(ServiceManyJobs, LabelsAndPriorityAreChanged) {
  const std::string blocking = block();
  const std::string first = s_.submit(tiny({{"labels", {{"a", "1"}}}})), second = s_.submit(tiny());
  EXPECT_EQ(patch(first, {{"labels", {{"b", "2"}}}}, 200)["request"]["labels"], Json({{"b", "2"}}));
  EXPECT_EQ(s_.get("/v1/jobs?label=b:2")["jobs"].size(), 1u);
  EXPECT_TRUE(s_.get("/v1/jobs?label=a:1")["jobs"].empty());
  EXPECT_EQ(patch(second, {{"priority", 5}}, 200)["request"]["priority"], 5);
  EXPECT_EQ(patch(blocking, {{"priority", -1}}, 200)["state"], "rendering");
  s_.post("/v1/jobs/" + blocking + "/cancel", "", 202);
  const Json early = s_.wait_end(second), late = s_.wait_end(first);
  EXPECT_LT(early["started"], late["started"]);  // it went before the one that was first
  EXPECT_EQ(late["request"]["labels"], Json({{"b", "2"}}));  // its run has not undone that
  EXPECT_EQ(patch(first, {{"labels", Json::object()}}, 200)["state"], "succeeded");

  EXPECT_EQ(patch(first, {{"priority", 6}}, 422)["errors"][0]["pointer"], "/priority");
  EXPECT_EQ(patch(first, {{"samples", 6}}, 422)["errors"][0]["pointer"], "/samples");
  patch(first, Json::object(), 422);
  patch("j999999", {{"priority", 1}}, 404);
  EXPECT_EQ(s_.client().Patch("/v1/jobs/" + first, "{", "application/json")->status, 400);
  EXPECT_EQ(s_.client().Patch("/v1/jobs/" + first, "{}", "text/plain")->status, 415);
}

TEST_F(ServiceManyJobs, ThoseThatFiltersFindAreDeleted) {
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i)
    ids.push_back(s_.submit(tiny({{"labels", {{"night", i < 3 ? "1" : "2"}}}})));
  for (const std::string& id : ids) s_.wait_end(id);
  const std::string blocking = block();
  EXPECT_EQ(remove("?label=night:1&limit=2"),
            Json({{"deleted", {ids[2], ids[1]}}, {"more", true}}));
  s_.get("/v1/jobs/" + ids[1], 404);
  EXPECT_FALSE(std::filesystem::exists(s_.config.data / "results" / ids[1]));
  EXPECT_EQ(remove("?label=night:1"), Json({{"deleted", {ids[0]}}, {"more", false}}));
  EXPECT_EQ(remove("?ended_before=2020-01-01T00:00:00Z")["deleted"], Json::array());
  // What has not ended stays.
  EXPECT_EQ(remove("?created_from=2020-01-01T00:00:00Z")["deleted"], Json({ids[3]}));
  EXPECT_EQ(s_.get("/v1/jobs/" + blocking)["state"], "rendering");

  for (const char* none : {"", "?limit=5"}) remove(none, 422);
  for (const char* wrong : {"state=queued", "state=x", "limit=0", "limit=201", "label=x",
                            "created_from=yesterday", "ended_before=2026-02-30T00:00:00Z"})
    EXPECT_EQ(remove(std::string("?") + wrong, 422)["errors"].size(), 1u) << wrong;
  remove("?surprise=1", 422);
  s_.post("/v1/jobs/" + blocking + "/cancel", "", 202);
  s_.wait_end(blocking);
}

TEST_F(ServiceManyJobs, AreListedByTime) {
  const std::string first = s_.submit(tiny());
  s_.wait_end(first);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  const std::string second = s_.submit(tiny());
  const Json job = s_.wait_end(second);
  const auto listed = [&](const std::string& query) {
    std::vector<std::string> ids;
    const Json list = s_.get("/v1/jobs?" + query);
    for (const Json& one : list["jobs"]) ids.push_back(one["id"]);
    return ids;
  };
  const std::string created = job["created"], ended = job["ended"];
  EXPECT_EQ(listed("created_from=" + created), std::vector{second});
  EXPECT_EQ(listed("created_before=" + created), std::vector{first});
  EXPECT_EQ(listed("ended_from=" + ended), std::vector{second});
  EXPECT_EQ(listed("ended_before=" + ended + "&state=succeeded"), std::vector{first});
  EXPECT_TRUE(listed("created_from=2100-01-01T00:00:00.5Z").empty());
  EXPECT_EQ(listed("q=" + second + "%20BOX"), std::vector{second});
  EXPECT_TRUE(listed("q=" + second + "%20none-such").empty());
}

}  // namespace
}  // namespace qray::server
