// What a client does with a job beside posting it: wait, pause, resume, extend, delete, post again.
#include <gtest/gtest.h>

#include <thread>

#include "tests/server/test_service.h"
#include "tests/support/sanitized.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

Json box(int samples) {
  return {{"scene", "box"}, {"samples", samples}, {"table", "none"}, {"seed", 3}};
}

std::string pixels(const TestService& s, const std::string& id) {
  const auto answer = s.client().Get("/v1/jobs/" + id + "/image.png");
  EXPECT_TRUE(answer && answer->status == 200) << id;
  return answer ? answer->body : "";
}

std::string log_of(const TestService& s, const std::string& id) {
  const auto answer = s.client().Get("/v1/jobs/" + id + "/log");
  EXPECT_TRUE(answer && answer->status == 200);
  return answer ? answer->body : "";
}

TEST(ServiceControl, APausedJobGoesOnToTheSamePicture) {
  TestService s;
  s.start();
  const int samples = qray::test::kSanitized ? 800 : 4000;  // takes longer than a pause
  const std::string whole = s.submit(box(samples)), cut = s.submit(box(samples));
  s.wait_end(whole);
  for (int i = 0; i < 3; ++i) {
    s.wait(cut, {"rendering", "learning"});
    Json job = s.post("/v1/jobs/" + cut + "/pause", "", 202);
    job = s.wait(cut, {"paused", "succeeded"});
    if (job["state"] == "succeeded") break;
    EXPECT_TRUE(job["ended"].is_null());
    s.post("/v1/jobs/" + cut + "/pause", "", 202);  // it is
    s.post("/v1/jobs/" + cut + "/resume", "", 202);
    s.post("/v1/jobs/" + cut + "/resume", "", 409);
  }
  const Json job = s.wait_end(cut);
  ASSERT_EQ(job["state"], "succeeded");
  EXPECT_EQ(job["progress"]["samples"], samples);
  EXPECT_EQ(pixels(s, cut), pixels(s, whole));
  EXPECT_NE(log_of(s, cut).find("info going on from a checkpoint"), std::string::npos)
      << log_of(s, cut);
  s.post("/v1/jobs/" + cut + "/pause", "", 409);
}

TEST(ServiceControl, AQueuedJobIsPausedAtOnceAndAPausedOneCanceled) {
  TestService s;
  s.start();
  const std::string running = s.submit(box(1'000'000));
  const std::string a = s.submit(box(4)), b = s.submit(box(4));
  EXPECT_EQ(s.post("/v1/jobs/" + a + "/pause", "", 202)["state"], "paused");
  EXPECT_EQ(s.post("/v1/jobs/" + b + "/pause", "", 202)["state"], "paused");
  EXPECT_EQ(s.post("/v1/jobs/" + b + "/cancel", "", 202)["state"], "canceled");
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
  s.wait_end(running);
  EXPECT_EQ(s.get("/v1/jobs/" + a)["state"], "paused");
  s.stop();
  s.start();  // paused it stays
  EXPECT_EQ(s.get("/v1/jobs/" + a)["state"], "paused");
  s.post("/v1/jobs/" + a + "/resume", "", 202);
  EXPECT_EQ(s.wait_end(a)["state"], "succeeded");
}

// Each order of these calls against the workers' taking the job from the queue.
TEST(ServiceControl, PausesAndResumesThatHammerAJobLoseNothing) {
  TestService s;
  s.config.jobs_at_once = 2;
  s.start();
  const std::string whole = s.submit(box(64)), id = s.submit(box(64));
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(1500);
  std::vector<std::jthread> clients;
  for (const char* action : {"pause", "resume", "pause", "resume"})
    clients.emplace_back([&, action] {
      httplib::Client client("127.0.0.1", s.service->port());
      client.set_keep_alive(true);
      while (std::chrono::steady_clock::now() < end) {
        const auto answer = client.Post("/v1/jobs/" + id + "/" + action);
        ASSERT_TRUE(answer) << "the server is gone";
        ASSERT_TRUE(answer->status == 202 || answer->status == 409) << answer->body;
      }
    });
  clients.clear();
  if (s.wait(id, {"paused", "succeeded"})["state"] == "paused")
    s.post("/v1/jobs/" + id + "/resume", "", 202);
  EXPECT_EQ(s.wait_end(id)["state"], "succeeded");
  EXPECT_EQ(s.wait_end(whole)["state"], "succeeded");
  EXPECT_EQ(pixels(s, id), pixels(s, whole));
}

TEST(ServiceControl, MoreIsRenderedOntoAJob) {
  TestService s;
  s.start();
  const std::string id = s.submit(box(8));
  const std::string base = "/v1/jobs/" + id;
  EXPECT_TRUE(s.wait_end(id)["extendable"]);
  const std::string before = pixels(s, id);
  EXPECT_EQ(s.post(base + "/extend", R"({"samples":8})", 202)["state"], "queued");
  Json job = s.wait_end(id);
  EXPECT_EQ(job["stats"]["samples"], 16);
  EXPECT_EQ(job["request"]["samples"], 16);
  EXPECT_NE(pixels(s, id), before);
  s.post(base + "/extend", R"({"seconds":0.5})", 202);
  job = s.wait_end(id);
  EXPECT_GT(job["stats"]["samples"], 16);
  EXPECT_TRUE(job["request"]["samples"].is_null());
  const double seconds = job["stats"]["seconds"];
  EXPECT_GT(seconds, 0.5);  // those before count

  for (const char* wrong : {"{}", R"({"samples":0})", R"({"samples":1,"seconds":1})",
                            R"({"samples":"8"})", R"({"more":1})"})
    s.post(base + "/extend", wrong, 422);
  s.post(base + "/extend", R"({"samples":1000000})", 422);
  EXPECT_EQ(s.get(base)["state"], "succeeded");
  const std::string running = s.submit(box(1'000'000));
  s.post("/v1/jobs/" + running + "/extend", R"({"samples":8})", 409);
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
}

TEST(ServiceControl, WithoutRoomForStatesNothingIsExtendable) {
  TestService s;
  s.config.checkpoint_mib = 0;
  s.start();
  const std::string id = s.submit(box(8));
  EXPECT_FALSE(s.wait_end(id)["extendable"]);
  s.post("/v1/jobs/" + id + "/extend", R"({"samples":8})", 409);
}

TEST(ServiceControl, AJobEndsWhenItsNoiseIsLow) {
  TestService s;
  s.start();
  Json request = {{"scene", "box"}, {"noise", 0.2}};
  Json job = s.wait_end(s.submit(request));
  EXPECT_LE(job["stats"]["noise"], 0.2);
  EXPECT_EQ(job["request"]["seconds"], 3600);
  const int few = job["stats"]["samples"];
  request["noise"] = 0.05;
  job = s.wait_end(s.submit(request));
  EXPECT_LE(job["stats"]["noise"], 0.05);
  EXPECT_GT(job["stats"]["samples"], few);
  request["samples"] = 2;  // whichever is first
  EXPECT_EQ(s.wait_end(s.submit(request))["stats"]["samples"], 2);
}

TEST(ServiceControl, DeletedJobsAreGone) {
  TestService s;
  s.start();
  const std::string id = s.submit(box(4)), base = "/v1/jobs/" + id;
  const Json job = s.wait_end(id);
  const auto folder = s.config.data;
  EXPECT_TRUE(std::filesystem::exists(folder / "results" / id));
  auto client = s.client();
  EXPECT_EQ(client.Delete(base)->status, 204);
  EXPECT_EQ(client.Delete(base)->status, 404);
  for (const char* path : {"", "/log", "/image.png", "/tiles"}) s.get(base + path, 404);
  EXPECT_FALSE(std::filesystem::exists(folder / "results" / id));
  EXPECT_FALSE(std::filesystem::exists(folder / "checkpoints" / id));
  EXPECT_TRUE(s.get("/v1/jobs")["jobs"].empty());
  const std::string running = s.submit(box(1'000'000));
  EXPECT_EQ(client.Delete("/v1/jobs/" + running)->status, 409);
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
}

TEST(ServiceControl, AKeyMakesAPostSafeToRepeat) {
  TestService s;
  s.start();
  auto client = s.client();
  const auto post = [&](const Json& request, const std::string& key) {
    return client.Post("/v1/jobs", {{"Idempotency-Key", key}}, request.dump(), "application/json");
  };
  const auto first = post(box(4), "a b");
  ASSERT_TRUE(first && first->status == 202);
  const std::string id = Json::parse(first->body)["id"];
  s.wait_end(id);
  const auto again = post(box(4), "a b");
  EXPECT_EQ(again->status, 202);
  EXPECT_EQ(again->get_header_value("Location"), "/v1/jobs/" + id);
  EXPECT_EQ(Json::parse(again->body)["state"], "succeeded");
  // The same in other words.
  Json same = box(4);
  same["method"] = "adaptive";
  EXPECT_EQ(Json::parse(post(same, "a b")->body)["id"], id);
  EXPECT_EQ(post(box(5), "a b")->status, 409);
  EXPECT_EQ(post(box(4), std::string(256, 'k'))->status, 400);
  EXPECT_EQ(post(box(4), "caf\xc3\xa9")->status, 400);
  EXPECT_NE(Json::parse(post(box(4), "another")->body)["id"], id);
  EXPECT_EQ(s.get("/v1/jobs")["jobs"].size(), 2u);
  // Many at once: one job.
  std::vector<std::jthread> posters;
  for (int i = 0; i < 8; ++i)
    posters.emplace_back([&] {
      s.client().Post("/v1/jobs", {{"Idempotency-Key", "race"}}, box(4).dump(), "application/json");
    });
  posters.clear();
  EXPECT_EQ(s.get("/v1/jobs")["jobs"].size(), 3u);
}

TEST(ServiceControl, TagsSayWhetherThereIsNews) {
  TestService s;
  s.start();
  const std::string id = s.submit(box(4)), base = "/v1/jobs/" + id;
  s.wait_end(id);
  auto client = s.client();
  for (const std::string& path :
       {base, std::string("/v1/jobs?limit=5"), base + "/image.png", base + "/image.exr"}) {
    const auto fresh = client.Get(path);
    const std::string tag = fresh->get_header_value("ETag");
    ASSERT_EQ(tag.size(), 34u) << path;
    const auto known = client.Get(path, {{"If-None-Match", tag}});
    EXPECT_EQ(known->status, 304) << path;
    EXPECT_TRUE(known->body.empty());
    EXPECT_EQ(client.Get(path, {{"If-None-Match", "\"other\""}})->status, 200) << path;
  }
}

TEST(ServiceControl, PicturesAreComparedWithAReference) {
  TestService s;
  s.start();
  const std::string few = s.submit(box(2)), more = s.submit(box(64));
  const std::string most = s.submit(box(qray::test::kSanitized ? 500 : 2000));
  Json other = box(1);
  other["width"] = 20;
  const std::string small = s.submit(other);
  for (const std::string& id : {few, more, most, small}) s.wait_end(id);
  const std::string pair = "/v1/compare?a=" + few + "&b=" + more;
  Json both = s.get(pair);
  EXPECT_TRUE(both["ref"].is_null());
  EXPECT_FALSE(both.contains("a_error"));
  EXPECT_GT(both["difference"]["relmse"], 0);
  both = s.get(pair + "&ref=" + most);
  EXPECT_GT(both["a_error"]["relmse"], 4 * both["b_error"]["relmse"].get<double>());
  EXPECT_GT(both["a_error"]["flip"], both["b_error"]["flip"]);
  EXPECT_NEAR(both["b_error"]["mean_ratio"], 1, 0.1);
  const Json same = s.get("/v1/compare?a=" + few + "&b=" + few)["difference"];
  EXPECT_EQ(same["relmse"], 0);
  EXPECT_EQ(same["mean_ratio"], 1);
  s.get("/v1/compare?a=" + few, 422);
  s.get("/v1/compare?b=" + few, 422);
  s.get("/v1/compare?a=" + few + "&b=x", 422);
  s.get("/v1/compare?a=" + few + "&b=j999999", 404);
  s.get(pair + "&ref=" + small, 422);
  s.get(pair + "&ref=", 422);
  s.get(pair + "&picture=recovered", 404);
  const std::string running = s.submit(box(1'000'000)), queued = s.submit(box(1));
  s.get("/v1/compare?a=" + few + "&b=" + queued, 409);
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
}

TEST(ServiceControl, WaitingClientsAreToldAtOnce) {
  TestService s;
  s.start();
  const std::string id = s.submit(box(1'000'000)), base = "/v1/jobs/" + id;
  s.wait(id, {"rendering", "learning"});
  std::jthread canceler([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    s.post(base + "/cancel", "", 202);
  });
  // Without waiting for the 60 s, or the suite's patience ends.
  for (std::string state; state != "canceled";)
    state = s.get(base + "?wait=60")["state"].get<std::string>();
  // An ended job has no more news; one that is not as the tag says is news.
  s.get(base + "?wait=60");
  const std::string tag = s.client().Get(base)->get_header_value("ETag");
  EXPECT_EQ(s.client().Get(base + "?wait=60", {{"If-None-Match", "\"x\""}})->status, 200);
  EXPECT_EQ(s.client().Get(base + "?wait=1", {{"If-None-Match", tag}})->status, 304);
  for (const char* wrong : {"-1", "61", "x", ""}) s.get(base + "?wait=" + wrong, 422);
}

TEST(ServiceControl, LabelsAndStatesFilterTheList) {
  TestService s;
  s.start();
  Json request = box(4);
  request["labels"] = {{"project", "lobby"}};
  request["priority"] = -5;
  const std::string id = s.submit(request);
  s.wait_end(id);
  s.wait_end(s.submit(box(4)));
  const Json jobs = s.get("/v1/jobs?label=project:lobby&state=succeeded")["jobs"];
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_EQ(jobs[0]["request"]["labels"]["project"], "lobby");
  EXPECT_EQ(jobs[0]["request"]["priority"], -5);
  EXPECT_TRUE(s.get("/v1/jobs?label=project:hall")["jobs"].empty());
  EXPECT_TRUE(s.get("/v1/jobs?state=failed")["jobs"].empty());
  for (const char* wrong : {"label=x", "label=:x", "label=A:x", "state=done", "state="})
    s.get(std::string("/v1/jobs?") + wrong, 422);
  for (const char* wrong :
       {R"({"scene":"box","priority":6})", R"({"scene":"box","priority":-6})",
        R"({"scene":"box","priority":"high"})", R"({"scene":"box","labels":[]})",
        R"({"scene":"box","labels":{"A":"x"}})", R"({"scene":"box","labels":{"a":1}})"}) {
    const Json problem = s.post("/v1/jobs", wrong, 422);
    EXPECT_EQ(problem["errors"].size(), 1u) << wrong;
  }
}

TEST(ServiceControl, JobsAtOnceShareTheMachine) {
  TestService s;
  s.config.jobs_at_once = 3;
  s.start();
  const std::string a = s.submit(box(1'000'000)), b = s.submit(box(1'000'000));
  // Neither waits for the other, and a short one for none.
  s.wait(a, {"rendering"});
  s.wait(b, {"rendering"});
  const Json job = s.wait_end(s.submit(box(16)));
  EXPECT_EQ(job["state"], "succeeded");
  for (const std::string& id : {a, b}) {
    EXPECT_EQ(s.get("/v1/jobs/" + id)["state"], "rendering");
    s.post("/v1/jobs/" + id + "/cancel", "", 202);
    s.wait_end(id);
  }
}

}  // namespace
}  // namespace qray::server
