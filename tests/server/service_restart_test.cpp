// What a data folder keeps over the end of one server and the start of the next.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "core/base/byte_io.h"
#include "core/base/file.h"
#include "core/image/picture_layers.h"
#include "core/render/checkpoint.h"
#include "tests/server/test_service.h"
#include "tests/support/render.h"
#include "tests/support/sanitized.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

Json tiny_of(int samples) {
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
  const std::string running = s.submit(tiny_of(100'000));
  const std::string queued = s.submit(tiny_of(4));
  s.wait(running, {"rendering"});
  s.stop();

  s.start();
  // The one put back goes on; it did not use up an attempt.
  s.wait(running, {"rendering"});
  EXPECT_EQ(s.get("/v1/jobs/" + queued)["state"], "queued");
  s.post("/v1/jobs/" + running + "/cancel", "", 202);
  EXPECT_EQ(s.wait_end(running)["state"], "canceled");
  EXPECT_EQ(s.wait_end(queued)["state"], "succeeded");
  EXPECT_EQ(s.submit(tiny_of(1)), "j000003");
}

// By their names.
std::map<std::string, Image> layers_of(const TestService& s, const std::string& id) {
  const qray::test::ScratchFolder scratch;
  const std::filesystem::path file = scratch / "passes.exr";
  std::ofstream(file, std::ios::binary) << body_of(s, "/v1/jobs/" + id + "/passes.exr");
  std::map<std::string, Image> layers;
  const std::vector<std::string> names = read_layer_names(file).value();
  for (const std::string& name : names) layers[name] = read_layer(file, name).value().image;
  return layers;
}

// A stop of the server in the middle of jobs, twice, changes no bit of their pictures and layers.
TEST(ServiceRestart, AnInterruptedJobGoesOnFromItsState) {
  TestService s;
  s.start();
  Json request = tiny_of(qray::test::kSanitized ? 2000 : 6000);  // takes a second or more
  request["learning_samples"] = qray::test::kSanitized ? 400 : 1000;
  request["table"] = "none";
  request["light_groups"] = "each";
  request["passes"] = {"bounces", "indirect"};
  request["region"] = {{"x", 3}, {"y", 4}, {"width", 20}, {"height", 10}};
  const std::string whole = s.submit(request), cut = s.submit(request);
  s.wait_end(whole);
  // Learning may be over before anybody asks.
  for (const char* state : {"learning", "rendering"}) {
    s.wait(cut, {state, "rendering", "succeeded"});
    s.stop();
    s.start();
  }
  ASSERT_EQ(s.wait_end(cut)["state"], "succeeded");
  EXPECT_EQ(body_of(s, "/v1/jobs/" + cut + "/image.png"),
            body_of(s, "/v1/jobs/" + whole + "/image.png"));
  const auto of_whole = layers_of(s, whole), of_cut = layers_of(s, cut);
  EXPECT_GE(of_whole.size(), 4u);
  ASSERT_EQ(of_cut.size(), of_whole.size());
  for (const auto& [name, image] : of_whole)
    EXPECT_TRUE(qray::test::same_bits(of_cut.at(name), image)) << name;
  const std::string log = body_of(s, "/v1/jobs/" + cut + "/log");
  EXPECT_NE(log.find("going on from a checkpoint"), std::string::npos) << log;
}

TEST(ServiceRestart, AStateThatIsOfNoUseIsSaidAndTheJobStartsAnew) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny_of(100'000));
  s.wait(id, {"rendering"});
  s.stop();
  test::write_text(s.config.data / "checkpoints" / id, "torn");
  s.start();
  s.wait(id, {"rendering"});
  s.post("/v1/jobs/" + id + "/cancel", "", 202);
  const Json job = s.wait_end(id);
  ASSERT_EQ(job["warnings"].size(), 1u) << job.dump();
  EXPECT_NE(job["warnings"][0].get<std::string>().find("starts anew"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(s.config.data / "checkpoints" / id));
}

// Makes a job's state one of another origin, as StateOrigin has it.
void rewrite_origin(const std::filesystem::path& file, uint32_t format, uint32_t revision,
                    const std::string& build) {
  const Bytes all = read_file(file, 1 << 26).value();
  ByteReader in(all);
  ByteWriter out;
  out.u64(in.u64());
  in.u32();
  out.u32(format);
  in.u32();
  out.u32(revision);
  in.string(1000);
  out.string(build);
  out.bytes(in.bytes(in.remaining() - 4));
  out.u32(crc32c(out.data()));
  ASSERT_TRUE(write_file_atomic(file, out.data()).ok());
}

Json extended(TestService& s, const std::string& id, int samples) {
  s.post("/v1/jobs/" + id + "/extend", Json{{"samples", samples}}.dump(), 202);
  return s.wait_end(id);
}

TEST(ServiceRestart, AfterAnUpgradeAJobGoesOnAndSaysSo) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny_of(8));
  EXPECT_FALSE(s.wait_end(id)["stats"]["mixed_builds"]);
  Json job;
  for (const char* build : {"oldest", "older", ""}) {
    s.stop();
    if (*build)
      rewrite_origin(s.config.data / "checkpoints" / id, kStateFormat, kStateRevision, build);
    s.start();
    job = extended(s, id, 4);
    ASSERT_EQ(job["state"], "succeeded") << job.dump();
    ASSERT_EQ(job["warnings"].size(), 1u) << job.dump();  // once, and for good
    EXPECT_NE(job["warnings"][0].get<std::string>().find("another build of qray rendered"),
              std::string::npos);
    EXPECT_TRUE(job["stats"]["mixed_builds"]);
  }
  EXPECT_EQ(job["stats"]["samples"], 20);
  EXPECT_NE(body_of(s, "/v1/jobs/" + id + "/log").find("another build of qray rendered"),
            std::string::npos);
}

TEST(ServiceRestart, AStateOfAnotherFormatOrRevisionIsNotGoneOnFrom) {
  for (const bool format : {true, false}) {
    TestService s;
    s.start();
    const std::string id = s.submit(tiny_of(8));
    s.wait_end(id);
    s.stop();
    rewrite_origin(s.config.data / "checkpoints" / id, kStateFormat - format,
                   kStateRevision + !format, "older");
    s.start();
    const Json job = extended(s, id, 4);
    ASSERT_EQ(job["state"], "succeeded") << job.dump();
    ASSERT_EQ(job["warnings"].size(), 1u) << job.dump();
    const std::string why = job["warnings"][0];
    EXPECT_NE(why.find("starts anew"), std::string::npos) << why;
    EXPECT_NE(why.find(format ? "is of format " : "(revision "), std::string::npos) << why;
    EXPECT_FALSE(job["stats"]["mixed_builds"]);
    EXPECT_EQ(job["stats"]["samples"], 12);
  }
}

TEST(ServiceRestart, MomentsOfAnOlderQrayAreLeftOutAndTheLogSaysSo) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny_of(2)), other = s.submit(tiny_of(2));
  s.wait_end(other);
  s.stop();
  std::filesystem::remove(s.config.data / "moments" / id);
  test::write_text(s.config.data / "history" / id, "memory of a build long ago");
  s.start();
  EXPECT_FALSE(std::filesystem::exists(s.config.data / "history"));
  EXPECT_TRUE(s.get("/v1/jobs/" + id + "/metrics")["moments"].empty());
  EXPECT_FALSE(s.get("/v1/jobs/" + other + "/metrics")["moments"].empty());
  const std::string said = "the moments kept so far are left out";
  EXPECT_NE(body_of(s, "/v1/jobs/" + id + "/log").find(said), std::string::npos);
  EXPECT_EQ(body_of(s, "/v1/jobs/" + other + "/log").find(said), std::string::npos);
}

TEST(ServiceRestart, EndedJobsAreKeptAsLongAsTheyShould) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny_of(1));
  s.wait_end(id);
  s.stop();
  s.config.keep_days = 1;
  s.start();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  s.get("/v1/jobs/" + id);
  s.stop();
  s.config.keep_days = 1e-9;
  s.start();
  for (int i = 0; i < 2000; ++i) {
    if (s.client().Get("/v1/jobs/" + id)->status == 404) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  FAIL() << "it is still there";
}

TEST(ServiceRestart, PicturesTablesAndRecordsStay) {
  TestService s;
  s.start();
  const std::string id = s.submit(tiny_of(8));
  const Json job = s.wait_end(id);
  const std::string base = "/v1/jobs/" + id;
  const std::string tiles = body_of(s, base + "/tiles?since=0");
  const std::string png = body_of(s, base + "/image.png?exposure=0.5");
  s.stop();

  s.start();
  EXPECT_EQ(s.get(base), job);
  EXPECT_EQ(body_of(s, base + "/tiles?since=0"), tiles);
  EXPECT_EQ(body_of(s, base + "/image.png?exposure=0.5"), png);
  const Json next = s.wait_end(s.submit(tiny_of(8)));
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
  const std::string running = s.submit(tiny_of(1'000'000));
  s.wait(running, {"rendering"});
  s.submit(tiny_of(1));
  s.submit(tiny_of(1));
  const auto full = s.client().Post("/v1/jobs", tiny_of(1).dump(), "application/json");
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
                  {"height", 48},   {"samples", 32},     {"guide", {{"grid", 500}}}};
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
