// Jobs of many frames over HTTP: their states, pictures, archives; what they become after a stop.
#include <gtest/gtest.h>
#include <zip.h>

#include <fstream>

#include "core/image/animation.h"
#include "tests/core/import/gltf_text.h"
#include "tests/server/test_service.h"
#include "tests/support/sanitized.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

Json turntable(int count, int samples) {
  return {{"scene", "box"},  {"width", 40},
          {"height", 40},    {"samples", samples},
          {"table", "none"}, {"frames", {{"turntable", count}, {"degrees", 30}}}};
}

std::string body_of(const TestService& s, const std::string& path, const char* type) {
  const auto answer = s.client().Get(path);
  EXPECT_TRUE(answer && answer->status == 200) << path << (answer ? answer->body : "");
  EXPECT_EQ(answer ? answer->get_header_value("Content-Type") : "", type);
  return answer ? answer->body : "";
}

std::string picture(const TestService& s, const std::string& id, int frame) {
  return body_of(s, "/v1/jobs/" + id + "/image.png?frame=" + std::to_string(frame), "image/png");
}

TEST(ServiceFrames, EachHasItsPictureAndStatistics) {
  TestService s;
  s.start();
  const std::string id = s.submit(turntable(3, 16));
  const Json job = s.wait_end(id);
  ASSERT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_EQ(job["progress"]["samples"], 16);
  EXPECT_EQ(job["stats"]["frames"], 3);
  const Json frames = s.get("/v1/jobs/" + id + "/frames")["frames"];
  ASSERT_EQ(frames.size(), 3u);
  uint64_t paths = 0;
  for (const Json& frame : frames) {
    EXPECT_EQ(frame["state"], "done");
    EXPECT_EQ(frame["samples"], 16);
    EXPECT_EQ(frame["fraction"], 1);
    paths += frame["stats"]["paths"].get<uint64_t>();
  }
  EXPECT_EQ(job["stats"]["paths"], paths);
  EXPECT_NE(picture(s, id, 0), picture(s, id, 1));
  EXPECT_NE(picture(s, id, 1), picture(s, id, 2));
  EXPECT_EQ(picture(s, id, 0), body_of(s, "/v1/jobs/" + id + "/image.png", "image/png"));
  s.get("/v1/jobs/" + id + "/image.png?frame=3", 404);
  s.get("/v1/jobs/" + id + "/image.png?frame=x", 422);
  EXPECT_GT(body_of(s, "/v1/jobs/" + id + "/tiles?frame=2", "application/octet-stream").size(),
            4u * 40 * 40);
  EXPECT_EQ(s.get("/v1/jobs/" + id + "/pixel?x=3&y=4&frame=1")["samples"], 16);
}

TEST(ServiceFrames, AnUploadMovesAsItsFileSays) {
  TestService s;
  s.config.program = qray::test::program("qrayd");
  s.start();
  qray::test::GltfText text = qray::test::gltf_triangle();
  text.json["nodes"][0]["scale"] = {2, 2, 1};
  text.animate(0, "translation", {0, 2}, {0, 0, 0, 3, 0, 0}, "VEC3");
  const std::string file = text.glb(), name = test::sha(file);
  ASSERT_EQ(s.client().Put("/v1/assets/" + name, file, "application/octet-stream")->status, 201);
  const Json scene = s.post("/v1/scenes", Json({{"asset", name}, {"type", "glb"}}).dump(), 201);
  const std::string id = s.submit({{"scene", scene["name"]},
                                   {"width", 24},
                                   {"height", 16},
                                   {"samples", 4},
                                   {"frames", {{"animation", 1}, {"seeds", "one"}}}});
  const Json job = s.wait_end(id);
  ASSERT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_EQ(job["request"]["frames"]["to"], 2);
  ASSERT_EQ(s.get("/v1/jobs/" + id + "/frames")["frames"].size(), 3u);
  EXPECT_NE(picture(s, id, 0), picture(s, id, 1));
  EXPECT_NE(picture(s, id, 1), picture(s, id, 2));
  // What a pixel sees is of its frame: the triangle has left the picture's left.
  const auto surface = [&](int frame) {
    return s.get("/v1/jobs/" + id + "/pixel?x=10&y=10&frame=" + std::to_string(frame))
        .value("surface", Json());
  };
  EXPECT_NE(surface(0), Json());
  EXPECT_EQ(surface(2), Json());
  const std::string box =
      s.submit({{"scene", "box"}, {"samples", 1}, {"frames", {{"animation", 24}}}});
  EXPECT_EQ(s.wait_end(box)["state"], "failed");
}

TEST(ServiceFrames, AJobWithoutThemHasNone) {
  TestService s;
  s.start();
  const std::string id = s.submit({{"scene", "box"}, {"samples", 1}});
  const Json job = s.wait_end(id);
  EXPECT_FALSE(job["request"].contains("frames"));
  EXPECT_FALSE(job["stats"].contains("frames"));
  EXPECT_EQ(s.get("/v1/jobs/" + id + "/frames")["frames"], Json::array());
  s.get("/v1/jobs/" + id + "/image.png?frame=1", 404);
  s.get("/v1/jobs/" + id + "/frames.gif", 404);
  s.get("/v1/jobs/" + id + "/frames.zip", 409);
}

TEST(ServiceFrames, TheyComeAsAnArchiveAndAsAFilm) {
  TestService s;
  s.start();
  const std::string id = s.submit(turntable(3, 2));
  s.wait_end(id);
  for (const char* format : {"png", "exr"}) {
    const std::string bytes =
        body_of(s, "/v1/jobs/" + id + "/frames.zip?format=" + format, "application/zip");
    const auto file = s.scratch / "frames.zip";
    std::ofstream(file, std::ios::binary) << bytes;
    zip_t* zip = zip_open(file.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
    ASSERT_NE(zip, nullptr);
    EXPECT_EQ(zip_get_num_entries(zip, 0), 3);
    EXPECT_EQ(zip_get_name(zip, 2, 0), std::string("frame-0002.") + format);
    zip_discard(zip);
  }
  EXPECT_EQ(body_of(s, "/v1/jobs/" + id + "/frames.gif?fps=8", "image/gif").substr(0, 6), "GIF89a");
  s.get("/v1/jobs/" + id + "/frames.gif?fps=0", 422);
  if (has_ffmpeg())
    EXPECT_EQ(body_of(s, "/v1/jobs/" + id + "/frames.mp4", "video/mp4").substr(4, 4), "ftyp");
  else
    s.get("/v1/jobs/" + id + "/frames.mp4", 422);
  EXPECT_TRUE(std::filesystem::is_empty(s.config.data / "answers"));
}

TEST(ServiceFrames, OneIsLeftOutAndRenderedAfterAll) {
  TestService s;
  s.start();
  const int samples = qray::test::kSanitized ? 500 : 2000;  // the last frame is asked about in time
  const std::string id = s.submit(turntable(3, samples)), of = "/v1/jobs/" + id;
  s.wait(id, {"learning", "rendering", "finalizing", "succeeded"});  // its frames are known
  // The order that spreads them is 0, 2, 1.
  s.post(of + "/frames/cancel?frame=1", "", 202);
  s.post(of + "/frames/cancel", "", 422);
  s.post(of + "/frames/cancel?frame=3", "", 404);
  s.post(of + "/frames/retry?frame=2", "", 409);
  ASSERT_EQ(s.wait_end(id)["state"], "succeeded");
  Json frames = s.get(of + "/frames")["frames"];
  EXPECT_EQ(frames[0]["state"], "done");
  EXPECT_EQ(frames[1]["state"], "canceled");
  EXPECT_EQ(frames[2]["state"], "done");
  s.get(of + "/image.png?frame=1", 409);
  s.post(of + "/frames/cancel?frame=2", "", 409);
  const std::string first = picture(s, id, 0);
  s.post(of + "/frames/retry?frame=1", "", 202);
  ASSERT_EQ(s.wait_end(id)["state"], "succeeded");
  frames = s.get(of + "/frames")["frames"];
  EXPECT_EQ(frames[1]["state"], "done");
  EXPECT_EQ(frames[1]["samples"], samples);
  EXPECT_EQ(picture(s, id, 0), first) << "the others stay as they were";
  picture(s, id, 1);
}

TEST(ServiceFrames, OneThatIsUnderWayEndsWithWhatItHas) {
  TestService s;
  s.start();
  const std::string id = s.submit(turntable(2, 1'000'000)), of = "/v1/jobs/" + id;
  for (int i = 0; i < 4000 && s.get("/v1/jobs/" + id)["progress"]["samples"] == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  s.post(of + "/frames/cancel?frame=0", "", 202);
  s.post(of + "/frames/cancel?frame=1", "", 202);
  ASSERT_EQ(s.wait_end(id)["state"], "succeeded");
  picture(s, id, 0);
  const std::string plain = s.submit({{"scene", "box"}, {"samples", 1}});
  s.post("/v1/jobs/" + plain + "/frames/cancel?frame=0", "", 404);
}

// Stopped twice in the middle and paused once, a job of frames ends with the same bits.
TEST(ServiceFrames, InterruptedTheyGoOnWithTheSameBits) {
  TestService s;
  s.start();
  const Json request = turntable(4, qray::test::kSanitized ? 200 : 700);
  const std::string whole = s.submit(request), cut = s.submit(request);
  s.wait_end(whole);
  for (int i = 0; i < 2; ++i) {
    s.wait(cut, {"learning", "rendering", "succeeded"});
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    s.stop();
    s.start();
  }
  s.wait(cut, {"learning", "rendering", "succeeded"});
  s.post("/v1/jobs/" + cut + "/pause", "",
         s.get("/v1/jobs/" + cut)["state"] == "succeeded" ? 409 : 202);
  if (s.wait(cut, {"paused", "succeeded"})["state"] == "paused")
    s.post("/v1/jobs/" + cut + "/resume", "", 202);
  ASSERT_EQ(s.wait_end(cut)["state"], "succeeded");
  for (int frame = 0; frame < 4; ++frame)
    EXPECT_EQ(picture(s, cut, frame), picture(s, whole, frame)) << frame;
}

TEST(ServiceFrames, MoreIsGivenToAll) {
  TestService s;
  s.start();
  const std::string id = s.submit(turntable(3, 4));
  EXPECT_TRUE(s.wait_end(id)["extendable"]);
  s.post("/v1/jobs/" + id + "/extend", R"({"samples":12})", 202);
  EXPECT_EQ(s.wait_end(id)["state"], "succeeded");
  const Json frames = s.get("/v1/jobs/" + id + "/frames");
  for (const Json& frame : frames["frames"]) {
    EXPECT_EQ(frame["samples"], 16);
    EXPECT_EQ(frame["state"], "done");
  }
}

TEST(ServiceFrames, CanceledTheyKeepWhatTheyHave) {
  TestService s;
  s.start();
  const std::string id = s.submit(turntable(3, 2000));
  for (int i = 0; i < 4000; ++i) {  // until the first is done
    if (s.get("/v1/jobs/" + id + "/frames")["frames"][0]["state"] == "done") break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  s.post("/v1/jobs/" + id + "/cancel", "", 202);
  EXPECT_EQ(s.wait_end(id)["state"], "canceled");
  EXPECT_FALSE(picture(s, id, 0).empty());
  const Json frames = s.get("/v1/jobs/" + id + "/frames")["frames"];
  EXPECT_EQ(frames[0]["state"], "done");
  EXPECT_EQ(frames[1]["state"], "waiting");  // the last in the order
  s.get("/v1/jobs/" + id + "/image.png?frame=1", 409);
}

TEST(ServiceFrames, RequestsThatMakeNoSenseAreRefused) {
  TestService s;
  s.start();
  const auto refuse = [&](const Json& frames, const std::string& pointer) {
    Json request = turntable(2, 1);
    request["frames"] = frames;
    const Json problem = s.post("/v1/jobs", request.dump(), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], pointer) << problem.dump();
  };
  refuse({{"turntable", 0}}, "/frames/turntable");
  refuse({{"turntable", 2}, {"cameras", {"a"}}}, "/frames/cameras");
  refuse({{"degrees", 90}}, "/frames/degrees");
  refuse({{"cameras", Json::array()}}, "/frames/cameras");
  refuse({{"cameras", {1}}}, "/frames/cameras/0");
  refuse({{"cameras", {{{"position", {1, 2}}}}}}, "/frames/cameras/0/position");
  refuse({{"cameras", {{{"fov", 2}}}}}, "/frames/cameras/0/fov");
  Json slow = turntable(1000, 1);
  slow.erase("samples");
  slow["seconds"] = 60;
  EXPECT_EQ(s.post("/v1/jobs", slow.dump(), 422)["errors"][0]["pointer"], "/seconds");
  // What only the scene can say is the job's failure.
  Json unknown = turntable(2, 1);
  unknown["frames"] = {{"cameras", {"back"}}};
  const std::string id = s.submit(unknown);
  Json job;
  for (int i = 0; i < 2000 && job["state"] != "failed"; ++i) {
    job = s.get("/v1/jobs/" + id);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(job["error"]["where"], "/frames/cameras/0") << job.dump();
}

}  // namespace
}  // namespace qray::server
