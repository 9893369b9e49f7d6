#include "proto/messages.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace qray::proto {
namespace {

using Json = nlohmann::json;

JobInfo queued_job() {
  JobInfo job;
  job.id = "j000001";
  job.state = "queued";
  job.request.set(field::kScene, "cornell-box");
  job.request.set(field::kSamples, 8);
  job.created_ms = 1'767'225'600'007;
  return job;
}

TEST(Messages, Time) {
  EXPECT_EQ(time_to_text(0), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(time_to_text(1'767'225'600'007), "2026-01-01T00:00:00.007Z");
  EXPECT_EQ(parse_time("2026-01-01T00:00:00.007Z"), 1'767'225'600'007);
  EXPECT_EQ(parse_time("2026-01-01T00:00:00.0079Z"), 1'767'225'600'007);
  EXPECT_EQ(parse_time("2026-01-01T00:00:00Z"), 1'767'225'600'000);
  EXPECT_EQ(parse_time("2024-02-29T23:59:59Z"), 1'709'251'199'000);
  for (const char* wrong :
       {"", "Z", "2026-01-01", "2026-01-01T00:00:00", "2026-01-01T00:00:00+01:00",
        "2026-01-01 00:00:00Z", "2026-02-29T00:00:00Z", "2026-13-01T00:00:00Z",
        "2026-01-01T24:00:00Z", "2026-01-01T00:60:00Z", "2026-01-01T00:00:00.Z",
        "2026-01-01T00:00:00.xZ", "2026-01-01T00:00:0xZ", "20260101T000000Z"})
    EXPECT_EQ(parse_time(wrong), std::nullopt) << wrong;
}

TEST(Messages, QueuedJobHasNullsWhereNothingIsKnown) {
  const Json json = Json::parse(job_to_json(queued_job()));
  EXPECT_EQ(json["id"], "j000001");
  EXPECT_EQ(json["created"], "2026-01-01T00:00:00.007Z");
  for (const char* name : {"started", "ended", "error", "table_in", "table_out", "stats"}) {
    ASSERT_TRUE(json.contains(name)) << name;
    EXPECT_TRUE(json[name].is_null()) << name;
  }
  EXPECT_EQ(json["progress"], (Json{{"fraction", 0.0}, {"samples", 0}, {"seconds", 0.0}}));
  EXPECT_EQ(json["biased"], false);
  EXPECT_EQ(json["warnings"], Json::array());
  EXPECT_EQ(json["request"]["samples"], 8);
  EXPECT_FALSE(json["request"].contains("seconds"));
}

TEST(Messages, EndedJob) {
  JobInfo job = queued_job();
  job.state = "failed";
  job.started_ms = 1000;
  job.ended_ms = 2000;
  job.progress = {0.5, 4, 1.25};
  job.error = JobError{"expected 1..4, got 0", "scene.json:/materials/3/ior"};
  job.table_in = "a";
  job.stats_json = R"({"rays":5})";
  job.biased = true;
  job.warnings = {"one"};
  const Json json = Json::parse(job_to_json(job));
  EXPECT_EQ(json["ended"], "1970-01-01T00:00:02.000Z");
  EXPECT_EQ(json["error"]["where"], "scene.json:/materials/3/ior");
  EXPECT_EQ(json["stats"]["rays"], 5);
  EXPECT_EQ(json["table_in"], "a");
  EXPECT_TRUE(json["table_out"].is_null());
  EXPECT_EQ(json["warnings"][0], "one");
}

TEST(Messages, BytesThatAreNotUtf8AreRepaired) {
  JobInfo job = queued_job();
  job.error = JobError{"bad \xff\xc3", "\xe2\x82"};
  const Json json = Json::parse(job_to_json(job));
  EXPECT_EQ(json["error"]["message"], "bad \xef\xbf\xbd\xef\xbf\xbd");
}

TEST(Messages, ListSaysWhenThereIsMore) {
  const JobInfo jobs[] = {queued_job(), queued_job()};
  const Json last = Json::parse(job_list_to_json(jobs, ""));
  EXPECT_EQ(last["jobs"].size(), 2u);
  EXPECT_FALSE(last.contains("next"));
  EXPECT_EQ(Json::parse(job_list_to_json(jobs, "j000007"))["next"], "j000007");
}

TEST(Messages, TablesAndScenes) {
  TableInfo table{"t", "room", "huang", {"p1", "p2"}, 0, 10, 20, 30, "j000001"};
  const Json tables = Json::parse(table_list_to_json({&table, 1}));
  EXPECT_EQ(tables["tables"][0]["parents"], (Json{"p1", "p2"}));
  EXPECT_EQ(tables["tables"][0]["samples_seen"], 30);
  const SceneInfo scenes[] = {{"a", 640, 480}, {"broken", {}, {}}};
  const Json list = Json::parse(scene_list_to_json(scenes));
  EXPECT_EQ(list["scenes"][0]["width"], 640);
  EXPECT_TRUE(list["scenes"][1]["width"].is_null());
}

TEST(Messages, ASceneReportComesBackAsItWas) {
  SceneReport report{JobError{"bad", "a.obj:3"}, "a.obj", 640, 480, 7, 8, {"w\n1", "w2"}};
  const auto back = parse_scene_report(scene_report_to_json(report));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->error->where, "a.obj:3");
  EXPECT_EQ(back->entry, "a.obj");
  EXPECT_EQ(back->height, 480);
  EXPECT_EQ(back->triangles, 7u);
  EXPECT_EQ(back->unpacked_bytes, 8u);
  EXPECT_EQ(back->warnings, report.warnings);
  for (const char* wrong : {"", "{", "[]", "{}", R"({"entry":1})"})
    EXPECT_FALSE(parse_scene_report(wrong)) << wrong;
  const std::string text = scene_report_to_json(report);
  for (size_t cut = 0; cut < text.size(); ++cut)
    EXPECT_FALSE(parse_scene_report(std::string_view(text).substr(0, cut))) << cut;
}

TEST(Messages, AManifestIsTheSameInAnyOrder) {
  const std::string a(64, 'a'), b(64, 'b');
  const auto manifest = [](const std::string& json) {
    return scene_manifest(std::get<SceneRequest>(parse_scene_request(json, {})));
  };
  const std::string one =
      manifest(R"({"files":{"x":")" + a + R"(","y":")" + b + R"("},"entry":"x"})");
  EXPECT_EQ(one, manifest(R"({"entry":"x","files":{"y":")" + b + R"(","x":")" + a + R"("}})"));
  EXPECT_NE(one, manifest(R"({"entry":"y","files":{"y":")" + b + R"(","x":")" + a + R"("}})"));
  EXPECT_NE(one, manifest(R"({"entry":"x","files":{"y":")" + a + R"(","x":")" + b + R"("}})"));
  EXPECT_EQ(manifest(R"({"type":"glb","asset":")" + a + "\"}"),
            manifest(R"({"files":{"scene.glb":")" + a + R"("},"entry":"scene.glb"})"));
  EXPECT_EQ(file_pointer("a/b~c.png"), "/files/a~1b~0c.png");
}

TEST(Messages, Problem) {
  const Json json = Json::parse(problem_to_json({422, "Wrong", "", {{"/a", "expected b"}}}));
  EXPECT_EQ(json["type"], "about:blank");
  EXPECT_EQ(json["status"], 422);
  EXPECT_EQ(json["errors"][0]["pointer"], "/a");
  EXPECT_FALSE(json.contains("detail"));
}

}  // namespace
}  // namespace qray::proto
