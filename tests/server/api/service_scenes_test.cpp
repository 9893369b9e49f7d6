// Scenes made of uploaded files: manifests, archives, and what a process of their own keeps away
// from the server.
#include <gtest/gtest.h>

#include "core/base/sha256.h"
#include "core/image/image_io.h"
#include "tests/server/make_zip.h"
#include "tests/server/test_service.h"
#include "tests/support/places.h"
#include "tests/support/sanitized.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;
using test::Json;
using test::make_zip;
using test::sha;
using test::TestService;

class ServiceScenes : public ::testing::Test {
 protected:
  void SetUp() override {
    s_.config.program = qray::test::program("qrayd");
    s_.start();
  }
  std::string put(const std::string& body) const {
    const std::string name = sha(body);
    const auto answer = s_.client().Put("/v1/assets/" + name, body, "application/octet-stream");
    EXPECT_TRUE(answer && answer->status / 100 == 2) << answer->body;
    return name;
  }
  Json post(const Json& request, int status) const {
    httplib::Client client = s_.client();
    client.set_read_timeout(60);
    const auto answer = client.Post("/v1/scenes", request.dump(), "application/json");
    EXPECT_TRUE(answer);
    EXPECT_EQ(answer->status, status) << answer->body;
    return Json::parse(answer->body);
  }
  Json post_files(const std::map<std::string, std::string>& files, int status) const {
    Json hashes = Json::object();
    for (const auto& [name, text] : files) hashes[name] = put(text);
    return post({{"files", hashes}}, status);
  }
  Json post_zip(const std::vector<test::ZipEntry>& entries, int status) const {
    return post({{"asset", put(make_zip(s_.scratch.path(), entries))}, {"type", "zip"}}, status);
  }
  // Of the only error of a problem.
  static void expect_fault(const Json& problem, const std::string& pointer,
                           const std::string& detail) {
    ASSERT_EQ(problem["errors"].size(), 1u) << problem.dump();
    EXPECT_EQ(problem["errors"][0]["pointer"], pointer) << problem.dump();
    const std::string text = problem["errors"][0]["detail"];
    EXPECT_NE(text.find(detail), std::string::npos) << text;
    EXPECT_EQ(text.find("qray-"), std::string::npos) << "a path of the server: " << text;
  }
  Json render(const std::string& scene) const {
    return s_.wait_end(s_.submit({{"scene", scene}, {"samples", 1}, {"method", "none"}}));
  }
  size_t scene_folders() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(s_.config.data / "scenes"), {}));
  }
  TestService s_;
};

// Triangles, many: the file is short to send and long to read.
std::string tall_obj(int quads) {
  std::string obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  for (int i = 0; i < quads; ++i) obj += "f 1 2 3 4\n";
  return obj;
}

TEST_F(ServiceScenes, AManifestBecomesASceneThatJobsRender) {
  const std::string obj = "mtllib a.mtl\nusemtl red\n" + tall_obj(1);
  const std::map<std::string, std::string> files = {
      {"room/a.obj", obj}, {"room/a.mtl", "newmtl red\nKd 1 0 0\n"}, {"note.txt", "x"}};
  const Json made = post_files(files, 201);
  const std::string name = made["name"];
  EXPECT_TRUE(name.starts_with("up-"));
  EXPECT_EQ(made["entry"], "room/a.obj");
  EXPECT_EQ(made["triangles"], 2);
  EXPECT_EQ(made["warnings"], Json::array());
  EXPECT_EQ(post_files(files, 200), made) << "the same again";
  EXPECT_EQ(s_.get("/v1/scenes/" + name), made);
  EXPECT_EQ(render(name)["state"], "succeeded");

  s_.stop();
  s_.start();
  EXPECT_EQ(s_.get("/v1/scenes/" + name), made);
  const Json list = s_.get("/v1/scenes")["scenes"];
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0]["name"], "box");
  EXPECT_EQ(list[0]["uploaded"], false);
  EXPECT_EQ(list[1]["name"], name);
  EXPECT_EQ(list[1]["uploaded"], true);
  EXPECT_EQ(render(name)["state"], "succeeded");
}

TEST_F(ServiceScenes, AZipBecomesAScene) {
  const std::vector<test::ZipEntry> entries = {{"box/scene.json", test::kBoxScene},
                                               {"box/other.obj", tall_obj(1)}};
  const Json made = post_zip(entries, 201);
  EXPECT_EQ(made["entry"], "box/scene.json");
  EXPECT_EQ(made["width"], 48);
  EXPECT_EQ(post_zip(entries, 200), made);
  EXPECT_EQ(render(made["name"])["state"], "succeeded");
  const std::string zip = put(make_zip(s_.scratch.path(), entries));
  const Json other = post({{"asset", zip}, {"type", "zip"}, {"entry", "box/other.obj"}}, 201);
  EXPECT_NE(other["name"], made["name"]);
  EXPECT_EQ(other["triangles"], 2);
  expect_fault(post({{"asset", zip}, {"type", "zip"}, {"entry", "box/none.obj"}}, 422), "/asset",
               "box/none.obj: there is no such file");
}

TEST_F(ServiceScenes, WrongRequestsNameThePlace) {
  const std::string hash = put("x");
  const std::pair<Json, std::pair<const char*, const char*>> cases[] = {
      {{{"files", {{"../a.obj", hash}}}}, {"/files/..~1a.obj", ".."}},
      {{{"files", {{"/a.obj", hash}}}}, {"/files/~1a.obj", "relative"}},
      {{{"files", {{"a\\b.obj", hash}}}}, {"/files/a\\b.obj", "backslash"}},
      {{{"files", {{"a.obj", hash}, {"a.OBJ", hash}}}}, {"/files/a.obj", "same name"}},
      {{{"files", {{"a", hash}, {"a/b.obj", hash}}}}, {"/files/a~1b.obj", "is a file"}},
      {{{"files", {{"a.obj", "abc"}}}}, {"/files/a.obj", "SHA-256"}},
      {{{"files", {{"a.obj", 7}}}}, {"/files/a.obj", "SHA-256"}},
      {{{"files", {{"a.txt", hash}}}}, {"/files", "expected a scene.json"}},
      {{{"files", {{"a.obj", hash}, {"b.obj", hash}}}}, {"/files", "name one"}},
      {{{"files", {{"a.obj", hash}}}, {"entry", "b.obj"}}, {"/entry", "one of the files"}},
      {{{"files", {{"a.obj", hash}}}, {"type", "zip"}}, {"/type", "belongs to"}},
      {{{"files", Json::object()}}, {"/files", "expected an object"}},
      {{{"files", {{"a.obj", hash}}}, {"asset", hash}}, {"", "got both"}},
      {Json::object(), {"", "none of the two"}},
      {{{"asset", hash}}, {"/type", "glb or zip"}},
      {{{"asset", hash}, {"type", "rar"}}, {"/type", "glb, zip"}},
      {{{"asset", "abc"}, {"type", "zip"}}, {"/asset", "SHA-256"}},
      {{{"asset", hash}, {"type", "zip"}, {"entry", "../x"}}, {"/entry", ".."}},
      {{{"asset", hash}, {"type", "glb"}, {"more", 1}}, {"/more", "unknown"}},
      {{{"asset", sha("gone")}, {"type", "zip"}}, {"/asset", "PUT /v1/assets/"}},
      {{{"files", {{"a.obj", sha("gone")}}}}, {"/files/a.obj", "no such asset"}},
  };
  for (const auto& [request, fault] : cases) {
    SCOPED_TRACE(request.dump());
    expect_fault(post(request, 422), fault.first, fault.second);
  }
  EXPECT_EQ(s_.client().Post("/v1/scenes", "{}", "text/plain")->status, 415);
  EXPECT_EQ(s_.client().Post("/v1/scenes", "{", "application/json")->status, 400);
  EXPECT_EQ(scene_folders(), 0u);
}

TEST_F(ServiceScenes, WhatIsWrongInAFileIsNamed) {
  expect_fault(post_files({{"s/a.obj", "v 0 0 zero\n"}}, 422), "/files/s~1a.obj", "a.obj:1");
  std::string scene = test::kBoxScene;
  scene.replace(scene.find("0.7"), 3, "7.7");
  expect_fault(post_files({{"scene.json", scene}}, 422), "/files/scene.json",
               "scene.json:/materials/0/reflectance");
  expect_fault(post_zip({{"scene.json", scene}}, 422), "/asset", "scene.json:/materials/0");
  expect_fault(post_zip({{"../scene.json", scene}}, 422), "/asset", "../scene.json: expected");
  expect_fault(post_zip({{"a.txt", "x"}}, 422), "/asset", "expected a scene.json");
  expect_fault(post({{"asset", put("no zip")}, {"type", "zip"}}, 422), "/asset", "not a zip");
  expect_fault(post({{"asset", put("no glb")}, {"type", "glb"}}, 422), "/files/scene.glb", "JSON");
  EXPECT_EQ(scene_folders(), 0u) << "nothing stays of what was refused";
}

// What each kind of scene can name: what is said of a path that exists must be what is said of one
// that does not.
TEST_F(ServiceScenes, WhatTheServerHasBesidesIsNotToldFromWhatItHasNot) {
  const std::string camera =
      R"("camera":{"position":[0,0,3],"target":[0,0,0],"vertical_fov_deg":40})";
  const auto json = [&](const std::string& more) { return "{" + camera + "," + more + "}"; };
  const auto mitsuba = [](const std::string& body) {
    return "<scene version=\"3.0.0\">" + body + "</scene>";
  };
  // A file, and its text with PATH in it.
  const struct {
    std::string name, text;
    std::map<std::string, std::string> others;
  } kinds[] = {
      {"a/scene.json",
       json(R"("materials":[{"name":"m","type":"diffuse"}],
               "meshes":[{"material":"m","file":"PATH"}])"),
       {}},
      {"a/scene.json",
       json(R"("textures":[{"name":"t","path":"PATH"}],"materials":[],"meshes":[])"),
       {}},
      {"a/scene.xml", mitsuba(R"(<include filename="PATH"/>)"), {}},
      {"a/scene.xml", mitsuba(R"(<path value="PATH"/>)"), {}},
      {"a/scene.xml",
       mitsuba(R"(<shape type="ply"><string name="filename" value="PATH"/></shape>)"),
       {}},
      {"a/scene.xml",
       mitsuba(R"(<shape type="serialized"><string name="filename" value="PATH"/></shape>)"),
       {}},
      {"a/scene.xml",
       mitsuba(R"(<emitter type="envmap"><string name="filename" value="PATH"/></emitter>)"),
       {}},
      {"a/scene.xml",
       mitsuba(R"(<shape type="cube"><bsdf type="diffuse"><texture name="reflectance"
         type="bitmap"><string name="filename" value="PATH"/></texture></bsdf></shape>)"),
       {}},
      {"a/scene.gltf",
       R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"PATH"}],
          "bufferViews":[{"buffer":0,"byteLength":4}],
          "accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"SCALAR"}],
          "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],
          "scenes":[{"nodes":[0]}]})",
       {}},
      {"a/scene.obj", "mtllib PATH\n" + tall_obj(1), {}},
      {"a/scene.obj",
       "mtllib m.mtl\nusemtl m\n" + tall_obj(1),
       {{"a/m.mtl", "newmtl m\nmap_Kd PATH\n"}}},
  };
  const fs::path there = s_.config.data / "scenes/there.ply";
  test::write_text(there, "there");
  const std::string up = "../../../";  // the draft's files, the draft, the scenes
  const std::pair<std::string, std::string> pairs[] = {
      {up + "../scenes/there.ply", up + "../scenes/absent.ply"},
      {there.string(), (s_.config.data / "scenes/absent.ply").string()},
      // By a way that leaves the folder and comes back to a file of the scene.
      {"../../files/a/x.ply", "../../absent/a/x.ply"},
  };
  for (const auto& kind : kinds)
    for (const auto& [exists, missing] : pairs) {
      std::vector<std::string> told;
      for (const std::string& path : {exists, missing}) {
        std::map<std::string, std::string> files = kind.others;
        files[kind.name] = kind.text;
        for (auto& [name, text] : files)
          if (const size_t at = text.find("PATH"); at != std::string::npos)
            text.replace(at, 4, path);
        files["a/x.ply"] = "ply";
        Json hashes = Json::object();
        for (const auto& [name, text] : files) hashes[name] = put(text);
        const auto answer =
            s_.client().Post("/v1/scenes", Json({{"files", hashes}, {"entry", kind.name}}).dump(),
                             "application/json");
        ASSERT_TRUE(answer);
        Json said = Json::parse(answer->body);
        const bool made = answer->status == 201;
        if (made) {
          const std::string scene = said["name"];
          EXPECT_EQ(s_.client().Delete("/v1/scenes/" + scene)->status, 204);
        }
        std::string text = made ? said["warnings"].dump() : said["detail"].get<std::string>();
        for (size_t at; (at = text.find(path)) != std::string::npos;)
          text.replace(at, path.size(), "PATH");
        told.push_back(std::to_string(answer->status) + " " + text);
      }
      EXPECT_EQ(told[0], told[1]) << kind.text << " with " << exists;
      EXPECT_TRUE(told[0].find("no such file in the scene's folder: ") != std::string::npos ||
                  told[0].find("a folder within the scene's") != std::string::npos)
          << told[0];
    }
}

TEST_F(ServiceScenes, PeopleCallThemAsTheyLike) {
  const std::string hash = put(tall_obj(1));
  const Json files = {{"a.obj", hash}};
  const Json made = post({{"files", files}, {"title", "Kitchen"}}, 201);
  const std::string path = "/v1/scenes/" + made["name"].get<std::string>();
  EXPECT_EQ(made["title"], "Kitchen");
  EXPECT_EQ(post({{"files", files}, {"title", "Other"}}, 200)["title"], "Kitchen") << "was there";
  const auto rename = [&](const std::string& at, const Json& body) {
    const auto answer = s_.client().Patch(at, body.dump(), "application/json");
    return std::pair(answer->status, Json::parse(answer->body));
  };
  EXPECT_EQ(rename(path, {{"title", "K\u00fcche"}}).second["title"], "K\u00fcche");
  s_.stop();
  s_.start();
  EXPECT_EQ(s_.get(path)["title"], "K\u00fcche");
  const Json list = s_.get("/v1/scenes")["scenes"];
  EXPECT_EQ(list[0]["title"], "box");
  EXPECT_EQ(list[1]["title"], "K\u00fcche");
  EXPECT_EQ(rename("/v1/scenes/box", {{"title", "mine"}}).first, 409);
  EXPECT_EQ(rename("/v1/scenes/none", {{"title", "mine"}}).first, 404);
  for (const Json& wrong : {Json::object(), Json({{"title", ""}}), Json({{"title", "a\nb"}}),
                            Json({{"title", std::string(121, 'a')}}), Json({{"title", 7}})}) {
    const auto [status, problem] = rename(path, wrong);
    EXPECT_EQ(status, 422) << wrong;
    EXPECT_EQ(problem["errors"][0]["pointer"], "/title") << problem;
  }
}

TEST_F(ServiceScenes, EachHasASmallPictureThatIsMadeOnce) {
  const auto ask = [&](const std::string& scene, const httplib::Headers& headers = {}) {
    return s_.client().Get("/v1/scenes/" + scene + "/thumbnail.jpg", headers);
  };
  const auto first = ask("box");
  ASSERT_EQ(first->status, 200);
  EXPECT_EQ(first->get_header_value("Content-Type"), "image/jpeg");
  const fs::path file = s_.scratch / "box.jpg";
  test::write_text(file, first->body);
  const Result<Image> image = read_image(file);
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(std::max(image.value().width(), image.value().height()), 192);
  EXPECT_EQ(ask("box", {{"If-None-Match", first->get_header_value("ETag")}})->status, 304);
  EXPECT_EQ(ask("none")->status, 404);

  const fs::path folder = s_.config.data / "thumbnails";
  const auto kept = [&] { return std::distance(fs::directory_iterator(folder), {}); };
  ASSERT_EQ(kept(), 1);
  test::write_text(fs::directory_iterator(folder)->path(), "kept");
  EXPECT_EQ(ask("box")->body, "kept");
  const fs::path scene = s_.config.scenes / "box/scene.json";
  test::write_text(scene, test::file_text(scene) + "\n");
  const std::string again = ask("box")->body;
  if (!qray::test::kSanitized) {  // else its time is too short for the same samples
    EXPECT_EQ(again, first->body) << "the scene has changed, and looks as before";
  }
  EXPECT_EQ(kept(), 1);
  test::write_text(scene, "{}");
  EXPECT_EQ(ask("box")->status, 422);

  s_.stop();
  fs::remove_all(s_.config.scenes / "box");
  s_.start();
  EXPECT_EQ(kept(), 0) << "of a scene that is gone";
}

TEST_F(ServiceScenes, APictureThatBreaksOffIsRefused) {
  Image image(64, 64, 3);
  for (size_t i = 0; i < image.data().size(); ++i)
    image.data()[i] = static_cast<float>(i * 7919 % 256) / 255;
  const Bytes bytes = encode_image(ImageFormat::kPng, image).value();
  const std::string png(bytes.begin(), bytes.end());
  const std::string obj =
      "mtllib a.mtl\nvt 0 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1/1 2/1 3/1\n";
  std::map<std::string, std::string> files = {
      {"a.obj", obj}, {"a.mtl", "newmtl m\nmap_Kd in/t.png\n"}, {"in/t.png", png}};
  post_files(files, 201);
  for (const size_t size : {png.size() / 2, size_t{20}, size_t{0}}) {
    files["in/t.png"] = png.substr(0, size);
    expect_fault(post_files(files, 422), "/files/in~1t.png", "in/t.png");
  }
}

TEST_F(ServiceScenes, OneThatTakesTooLongIsEndedAndTheServerGoesOn) {
  s_.stop();
  s_.config.import_seconds = 1;
  s_.start();
  expect_fault(post_files({{"a.obj", tall_obj(2'400'000)}}, 422), "/files/a.obj",
               "within 1 s and 2048 MiB");
  EXPECT_EQ(s_.get("/healthz")["status"], "ok");
  EXPECT_EQ(scene_folders(), 0u);
}

TEST_F(ServiceScenes, OneThatTakesTooMuchMemoryIsEndedAndTheServerGoesOn) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "addresses are not limited in this build";
#endif
  s_.stop();
  s_.config.import_mib = 512;
  s_.start();
  expect_fault(post_files({{"a.obj", tall_obj(2'400'000)}}, 422), "/files/a.obj",
               "512 MiB: it takes more memory");
  EXPECT_EQ(post_files({{"a.obj", tall_obj(1)}}, 201)["triangles"], 2) << "small ones still fit";
}

TEST_F(ServiceScenes, ACrashIsAnAnswer) {
  s_.stop();
  test::write_text(s_.scratch / "crash", "#!/bin/sh\nkill -SEGV $$\n");
  fs::permissions(s_.scratch / "crash", fs::perms::owner_all);
  s_.config.program = s_.scratch / "crash";
  s_.start();
  expect_fault(post_files({{"a.obj", tall_obj(1)}}, 422), "/files/a.obj", "crashed");
  s_.stop();
  test::write_text(s_.scratch / "crash", "#!/bin/sh\nexec cat /dev/zero >&3\n");
  s_.start();
  expect_fault(post_files({{"a.obj", tall_obj(1)}}, 422), "/files/a.obj", "says too much");
  s_.stop();
  s_.config.program = s_.scratch / "not there";
  s_.start();
  post_files({{"a.obj", tall_obj(1)}}, 503);
}

TEST_F(ServiceScenes, StoppingEndsWhatIsRead) {
  s_.stop();
  test::write_text(s_.scratch / "sleep", "#!/bin/sh\necho $$ > " + (s_.scratch / "pid").string() +
                                             "\nsleep 1000 & sleep 1000\n");
  fs::permissions(s_.scratch / "sleep", fs::perms::owner_all);
  s_.config.program = s_.scratch / "sleep";
  s_.start();
  const Json request = {{"files", {{"a.obj", put(tall_obj(1))}}}};
  std::jthread asks([&, port = s_.service->port()] {
    httplib::Client("127.0.0.1", port).Post("/v1/scenes", request.dump(), "application/json");
  });
  while (test::file_text(s_.scratch / "pid").find('\n') == std::string::npos)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const int pid = std::stoi(test::file_text(s_.scratch / "pid"));
  const auto begin = std::chrono::steady_clock::now();
  s_.stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  EXPECT_EQ(::kill(pid, 0), -1) << "it still runs";
  EXPECT_EQ(scene_folders(), 0u);
}

TEST_F(ServiceScenes, AreDeletedWhenNoJobNeedsThem) {
  const std::string name = post_zip({{"scene.json", test::kBoxScene}}, 201)["name"];
  const std::string job = s_.submit(
      {{"scene", name}, {"samples", 1'000'000}, {"method", "none"}, {"width", 64}, {"height", 64}});
  const auto refused = s_.client().Delete("/v1/scenes/" + name);
  EXPECT_EQ(refused->status, 409);
  EXPECT_NE(refused->body.find(job), std::string::npos) << refused->body;
  s_.post("/v1/jobs/" + job + "/cancel", "", 202);
  s_.wait_end(job);
  EXPECT_EQ(s_.client().Delete("/v1/scenes/" + name)->status, 204);
  EXPECT_EQ(s_.client().Delete("/v1/scenes/" + name)->status, 404);
  EXPECT_EQ(s_.client().Delete("/v1/scenes/box")->status, 409);
  EXPECT_EQ(s_.get("/v1/scenes/" + name, 404)["status"], 404);
  EXPECT_EQ(scene_folders(), 0u);
  s_.post("/v1/jobs", Json{{"scene", name}}.dump(), 422);
}

TEST_F(ServiceScenes, AJobAndADeletionAtOnceDoNotMeet) {
  for (int i = 0; i < 6; ++i) {
    const std::string name = post_zip({{"scene.json", test::kBoxScene}}, 201)["name"];
    const Json job = {{"scene", name}, {"samples", 1}, {"method", "none"}};
    int posted = 0, deleted = 0;
    {
      std::jthread one(
          [&] { posted = s_.client().Post("/v1/jobs", job.dump(), "application/json")->status; });
      deleted = s_.client().Delete("/v1/scenes/" + name)->status;
    }
    const Json newest = s_.get("/v1/jobs?limit=1")["jobs"];
    if (posted == 202) {
      EXPECT_EQ(s_.wait_end(newest[0]["id"])["state"], "succeeded");
    } else {
      EXPECT_EQ(posted, 422);
      EXPECT_EQ(deleted, 204);
    }
    s_.client().Delete("/v1/scenes/" + name);
  }
}

TEST_F(ServiceScenes, AreCounted) {
  s_.stop();
  for (int i = 0; i < 1000; ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "up-%032x", i);
    test::write_text(
        s_.config.data / "scenes" / name / "report.json",
        R"({"entry":"a","width":1,"height":1,"triangles":1,"unpacked_bytes":0,"warnings":[]})");
  }
  s_.start();
  const Json full = post_files({{"a.obj", tall_obj(1)}}, 507);
  EXPECT_NE(full["detail"].get<std::string>().find("1000"), std::string::npos) << full;
  EXPECT_EQ(s_.client().Delete("/v1/scenes/up-" + std::string(32, '0'))->status, 204);
  post_files({{"a.obj", tall_obj(1)}}, 201);
}

TEST_F(ServiceScenes, DraftsOfAKilledServerAreRemoved) {
  s_.stop();
  test::write_text(s_.config.data / "scenes/0.draft/files/a.obj", "x");
  s_.start();
  EXPECT_EQ(scene_folders(), 0u);
}

TEST_F(ServiceScenes, WhatUnpacksToTooMuchIsRefused) {
  s_.stop();
  s_.config.unpacked_mib = 1;
  s_.start();
  expect_fault(post_zip({{"scene.json", test::kBoxScene}, {"big", std::string(2 << 20, 'x')}}, 422),
               "/asset", "big: the archive's files take more than 1048576 bytes");
}

}  // namespace
}  // namespace qray::server
