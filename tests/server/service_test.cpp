// The whole service on a scratch folder: a job's life over HTTP.
#include "server/service.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "core/image/rgb9e5.h"
#include "core/job/load_and_prepare.h"
#include "core/job/run_job.h"
#include "core/settings/job_settings.h"
#include "server/store/picture.h"
#include "tests/server/pictures.h"

namespace qray::server {
namespace {

using std::chrono::seconds;
using test::Json;
using test::TestService;

const Json kTiny = {
    {"scene", "box"}, {"width", 32}, {"height", 32}, {"samples", 16}, {"learning_samples", 16}};

Json tiny(const Json& changes) {
  Json request = kTiny;
  request.update(changes);
  return request;
}

class ServiceTest : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  Bytes download(const std::string& path) const {
    const auto answer = s_.client().Get(path);
    if (!answer || answer->status != 200) {
      ADD_FAILURE() << path << ": " << (answer ? answer->body : "no answer");
      return {};
    }
    return Bytes(answer->body.begin(), answer->body.end());
  }
  Image exr(const std::string& id) const {
    return test::get_picture(s_, "/v1/jobs/" + id + "/image.exr").image;
  }
  // What run_job alone makes of the same request.
  Image rendered_directly(const Json& request, int threads) const {
    const auto parsed = proto::parse_job_request(request.dump(), {});
    const auto scene = load_and_prepare_scene(s_.config.scenes / "box/scene.json", 1);
    const RenderSettings settings = settings_of(std::get<JobRequest>(parsed), scene.value()->scene);
    Film film(settings.width, settings.height);
    TaskPool pool(threads);
    RenderObserver observer;
    const auto result =
        run_job(*scene.value(), settings, {}, film, pool, observer, {}, SteadyClock());
    EXPECT_TRUE(result.ok());
    return film.develop();
  }

  TestService s_;
};

TEST_F(ServiceTest, AJobsLife) {
  const auto answer = s_.client().Post("/v1/jobs", kTiny.dump(), "application/json");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 202);
  const Json queued = Json::parse(answer->body);
  const std::string id = queued["id"];
  EXPECT_EQ(answer->get_header_value("Location"), "/v1/jobs/" + id);
  EXPECT_EQ(queued["request"]["width"], 32);
  const Json job = s_.wait_end(id);
  EXPECT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_EQ(job["progress"]["fraction"], 1.0);
  EXPECT_EQ(job["progress"]["samples"], 16);
  EXPECT_EQ(job["stats"]["method"], "adaptive");
  EXPECT_GT(job["stats"]["rays"], 0);
  EXPECT_EQ(job["stats"]["threads"], 2);
  EXPECT_TRUE(job["error"].is_null());
  EXPECT_TRUE(job["started"].is_string());
  EXPECT_TRUE(job["ended"].is_string());
  EXPECT_FALSE(job["biased"]);
  const Json list = s_.get("/v1/jobs");
  EXPECT_EQ(list["jobs"].size(), 1u);
  EXPECT_EQ(list["jobs"][0], job);
}

TEST_F(ServiceTest, SizesAndDepthAreTheScenesOwn) {
  const Json queued = s_.post("/v1/jobs", R"({"scene":"box","samples":1})", 202);
  EXPECT_EQ(queued["request"]["width"], 48);
  EXPECT_EQ(queued["request"]["height"], 40);
  const Json job = s_.wait_end(queued["id"]);
  EXPECT_EQ(job["stats"]["width"], 48);
  EXPECT_TRUE(job["request"]["max_depth"].is_number());
}

TEST_F(ServiceTest, SamePictureAsTheCommandBitForBit) {
  for (const char* method : {"none", "huang", "adaptive"}) {
    const Json request = tiny({{"method", method}, {"table", "none"}, {"seed", 9}});
    const std::string id = s_.submit(request);
    s_.wait_end(id);
    EXPECT_TRUE(test::same_bits(exr(id), rendered_directly(request, 1))) << method;
  }
}

TEST_F(ServiceTest, TheSecondJobStartsFromTheFirstOnesTable) {
  const std::string first = s_.submit(kTiny);
  const Json cold = s_.wait_end(first);
  EXPECT_TRUE(cold["table_in"].is_null());
  ASSERT_TRUE(cold["table_out"].is_string());
  const std::string second = s_.submit(tiny({{"seed", 2}, {"samples", 20}}));
  const Json warm = s_.wait_end(second);
  EXPECT_EQ(warm["table_in"], cold["table_out"]);
  EXPECT_NE(warm["table_out"], cold["table_out"]);

  const Json tables = s_.get("/v1/tables")["tables"];
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0]["id"], warm["table_out"]);
  EXPECT_EQ(tables[0]["parents"], Json::array({cold["table_out"]}));
  EXPECT_EQ(tables[0]["job"], second);
  EXPECT_GT(tables[0]["samples_seen"], tables[1]["samples_seen"]);
  EXPECT_EQ(tables[0]["bytes"],
            std::filesystem::file_size(s_.config.data / "tables" /
                                       (tables[0]["id"].get<std::string>() + ".qrt")));
  const auto metadata = read_image_metadata(s_.config.data / "results" / second / "image.exr");
  EXPECT_EQ(metadata.value().at("table_in"), cold["table_out"]);
}

TEST_F(ServiceTest, TablesByIdAndByNone) {
  const std::string table = s_.wait_end(s_.submit(kTiny))["table_out"];
  s_.wait_end(s_.submit(tiny({{"seed", 3}})));
  const Json by_id = s_.wait_end(s_.submit(tiny({{"table", table}})));
  EXPECT_EQ(by_id["table_in"], table);
  const Json none = s_.wait_end(s_.submit(tiny({{"table", "none"}})));
  EXPECT_TRUE(none["table_in"].is_null());
  EXPECT_TRUE(none["table_out"].is_null());
  s_.post("/v1/jobs", tiny({{"table", table}, {"method", "none"}}).dump(), 422);
}

TEST_F(ServiceTest, ATableOfAnotherGridIsPassedOver) {
  s_.wait_end(s_.submit(tiny({{"method", "huang"}})));
  const Json other = s_.wait_end(s_.submit(tiny({{"method", "huang"}, {"guide", {{"grid", 3}}}})));
  EXPECT_EQ(other["state"], "succeeded");
  EXPECT_TRUE(other["table_in"].is_null());
  EXPECT_EQ(other["warnings"].size(), 1u);
  const Json again =
      s_.wait_end(s_.submit(tiny({{"method", "huang"}, {"guide", {{"grid", 3}}}, {"seed", 2}})));
  EXPECT_EQ(again["table_in"], other["table_out"]);
}

TEST_F(ServiceTest, ADamagedTableIsPutAsideAndTheJobRunsCold) {
  const std::string table = s_.wait_end(s_.submit(kTiny))["table_out"];
  const auto file = s_.config.data / "tables" / (table + ".qrt");
  Bytes bytes = read_file(file, 1 << 28).value();
  bytes[bytes.size() / 2] ^= 1;
  ASSERT_TRUE(write_file_atomic(file, bytes).ok());
  const Json job = s_.wait_end(s_.submit(tiny({{"seed", 2}})));
  EXPECT_EQ(job["state"], "succeeded");
  EXPECT_TRUE(job["table_in"].is_null());
  ASSERT_EQ(job["warnings"].size(), 1u);
  EXPECT_NE(job["warnings"][0].get<std::string>().find(table), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(s_.config.data / "quarantine" / (table + ".qrt")));
}

TEST_F(ServiceTest, BiasedMethodsAreMarked) {
  EXPECT_TRUE(s_.wait_end(s_.submit(tiny({{"method", "huang-published"}})))["biased"]);
}

TEST_F(ServiceTest, TilesByCursor) {
  const std::string id = s_.submit(tiny({{"width", 150}, {"height", 70}}));
  const std::string path = "/v1/jobs/" + id + "/tiles?since=";
  const Json ended = s_.wait_end(id);
  const Bytes bytes = download(path + "0");
  ByteReader in(bytes);
  in.bytes(4);
  EXPECT_EQ(in.u32(), 150u);
  EXPECT_EQ(in.u32(), 70u);
  const uint64_t cursor = in.u64();
  const uint32_t tiles = in.u32();
  EXPECT_EQ(tiles, 6u);
  EXPECT_EQ(in.u32(), 0u);
  const Image image = exr(id);
  for (uint32_t t = 0; t < tiles; ++t) {
    const uint32_t x0 = in.u32(), y0 = in.u32(), w = in.u32(), h = in.u32();
    EXPECT_EQ(in.u32(), 16u);
    const uint32_t crc = in.u32();
    const auto payload = in.bytes(size_t{4} * w * h);
    ASSERT_TRUE(in.ok());
    EXPECT_EQ(crc, crc32c(payload));
    ByteReader pixels(payload);
    for (uint32_t y = 0; y < h; ++y) {
      for (uint32_t x = 0; x < w; ++x) {
        const Rgb expected = image.rgb(static_cast<int>(x0 + x), static_cast<int>(y0 + y));
        ASSERT_EQ(pixels.u32(), pack_rgb9e5(expected)) << x0 + x << "," << y0 + y;
      }
    }
  }
  EXPECT_EQ(in.remaining(), 0u);
  const Bytes none = download(path + std::to_string(cursor));
  EXPECT_EQ(none.size(), 28u);
  EXPECT_LT(download(path + std::to_string(cursor - 1)).size(), bytes.size());
}

TEST_F(ServiceTest, ImagesAndTheirMetadata) {
  const std::string id = s_.submit(tiny({{"seed", 77}}));
  const Json job = s_.wait_end(id);
  const ImageMetadata m = test::get_picture(s_, "/v1/jobs/" + id + "/image.exr").metadata;
  EXPECT_EQ(m.at("seed"), "77");
  EXPECT_EQ(m.at("samples"), "16");
  EXPECT_EQ(m.at("method"), "adaptive");
  EXPECT_EQ(m.at("table_out"), job["table_out"]);
  EXPECT_EQ(m.at("scene_hash").size(), 64u);

  const auto mean_of = [&](const std::string& exposure) {
    const Image image = test::get_picture(s_, "/v1/jobs/" + id + "/image.png" + exposure).image;
    double sum = 0;
    for (float v : image.data()) sum += v;
    return sum;
  };
  EXPECT_GT(mean_of("?exposure=1"), mean_of(""));
  EXPECT_LT(mean_of("?exposure=-1.5"), mean_of(""));
  // What it chose is said, and gives the same picture when it is asked for.
  const auto automatic = s_.client().Get("/v1/jobs/" + id + "/image.png?exposure=auto");
  ASSERT_TRUE(automatic && automatic->status == 200);
  const std::string stops = automatic->get_header_value("Qray-Exposure");
  EXPECT_EQ(mean_of("?exposure=auto"), mean_of("?exposure=" + stops));
  EXPECT_NE(mean_of("?exposure=auto"), mean_of(""));
  s_.get("/v1/jobs/" + id + "/image.png?exposure=x", 422);
  s_.get("/v1/jobs/" + id + "/image.png?exposure=99", 422);
}

TEST_F(ServiceTest, ARunningJobShowsItsPictureAndCanBeCanceled) {
  const std::string id = s_.submit(tiny({{"samples", 1'000'000}}));
  const std::string waiting = s_.submit(kTiny);
  s_.get("/v1/jobs/" + waiting + "/image.exr", 409);
  s_.wait(id, {"rendering"});
  while (s_.client().Get("/v1/jobs/" + id + "/image.png")->status != 200) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_GT(download("/v1/jobs/" + id + "/image.exr").size(), 100u);
  EXPECT_GT(download("/v1/jobs/" + id + "/tiles?since=0").size(), 4000u);
  EXPECT_GT(s_.get("/v1/jobs/" + id)["progress"]["seconds"], 0.0);

  const auto begin = std::chrono::steady_clock::now();
  const Json canceling = s_.post("/v1/jobs/" + id + "/cancel", "", 202);
  EXPECT_EQ(canceling["id"], id);
  const Json canceled = s_.wait_end(id);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, seconds(2));
  EXPECT_EQ(canceled["state"], "canceled");
  EXPECT_GT(download("/v1/jobs/" + id + "/tiles?since=0").size(), 4000u);  // still there
  exr(id);
  s_.post("/v1/jobs/" + id + "/cancel", "", 409);
  EXPECT_EQ(s_.wait_end(waiting)["state"], "succeeded");
}

TEST_F(ServiceTest, AQueuedJobIsCanceledAtOnce) {
  const std::string running = s_.submit(tiny({{"samples", 1'000'000}}));
  const std::string queued = s_.submit(kTiny);
  EXPECT_EQ(s_.post("/v1/jobs/" + queued + "/cancel", "", 202)["state"], "canceled");
  s_.get("/v1/jobs/" + queued + "/image.png", 409);
  EXPECT_EQ(download("/v1/jobs/" + queued + "/tiles").size(), 28u);
  s_.post("/v1/jobs/" + running + "/cancel", "", 202);
  s_.wait_end(running);
}

TEST_F(ServiceTest, ABadSceneFailsTheJobWithFileAndPlace) {
  std::string text = test::kBoxScene;
  text.replace(text.find("0.7, 0.7, 0.7"), 13, "0.7, 0.7, 9.9");
  test::write_text(s_.config.scenes / "wrong/scene.json", text);
  const std::string id = s_.submit({{"scene", "wrong"}});
  Json job = Json::object();
  for (int i = 0; i < 1000 && job.value("state", "") != "failed"; ++i) {
    job = s_.get("/v1/jobs/" + id);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(job["state"], "failed");
  const std::string where = job["error"]["where"];
  EXPECT_NE(where.find("scene.json"), std::string::npos) << where;
  EXPECT_NE(where.find("/materials/0/reflectance"), std::string::npos) << where;
  EXPECT_EQ(where.find(s_.scratch.path().string()), std::string::npos) << where;
  EXPECT_FALSE(job["error"]["message"].get<std::string>().empty());
}

TEST_F(ServiceTest, AJobByTime) {
  Json request = kTiny;
  request.erase("samples");
  request["seconds"] = 0.1;
  const Json job = s_.wait_end(s_.submit(request));
  EXPECT_EQ(job["state"], "succeeded");
  EXPECT_FALSE(job["request"].contains("samples"));
}

TEST_F(ServiceTest, JobsInPages) {
  for (int i = 0; i < 5; ++i) s_.submit(tiny({{"samples", 1}}));
  const Json first = s_.get("/v1/jobs?limit=3");
  ASSERT_EQ(first["jobs"].size(), 3u);
  EXPECT_EQ(first["jobs"][0]["id"], "j000005");
  EXPECT_EQ(first["next"], "j000003");
  const Json second = s_.get("/v1/jobs?limit=3&before=j000003");
  EXPECT_EQ(second["jobs"].size(), 2u);
  EXPECT_FALSE(second.contains("next"));
}

TEST_F(ServiceTest, ScenesHealthAndPage) {
  const Json scenes = s_.get("/v1/scenes");
  EXPECT_EQ(
      scenes["scenes"],
      Json::parse(R"([{"name":"box","width":48,"height":40,"uploaded":false,"title":"box"}])"));
  EXPECT_EQ(s_.get("/healthz")["status"], "ok");
  const auto page = s_.client().Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->get_header_value("Content-Type"), "text/html; charset=utf-8");
  EXPECT_NE(page->get_header_value("Content-Security-Policy").find("default-src 'self'"),
            std::string::npos);
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(page->get_header_value_count("Cache-Control"), 1u);
  for (const char* path : {"/../data/lock", "/%2e%2e/data/lock", "/scene.json", "/index.html/",
                           "//index.html", "/index.html%00"}) {
    EXPECT_EQ(s_.client().Get(path)->status, 404) << path;
  }
}

TEST_F(ServiceTest, TheContractListsEveryRouteWithItsScopeAndNoOther) {
  std::map<std::string, std::string> routes;
  for (const Router::RouteInfo& route : s_.service->routes()) {
    const bool usual = route.needed == usual_scope(route.method);
    routes[route.method + " " + qray::test::without_names(route.pattern)] =
        usual ? "" : name_of(route.needed);
  }
  EXPECT_EQ(routes, qray::test::Contract::instance().calls());
}

struct Wrong {
  const char* method;
  std::string path, body, type;
  int status;
  const char* pointer;
};

TEST_F(ServiceTest, WrongRequests) {
  const std::string json = "application/json";
  const Wrong cases[] = {
      {"POST", "/v1/jobs", "{}", json, 422, "/scene"},
      {"POST", "/v1/jobs", "", json, 400, nullptr},
      {"POST", "/v1/jobs", "{", json, 400, nullptr},
      {"POST", "/v1/jobs", "{}", "text/plain", 415, nullptr},
      {"POST", "/v1/jobs", "scene=box", "application/x-www-form-urlencoded", 415, nullptr},
      {"POST", "/v1/jobs", std::string(100'000, '['), json, 400, nullptr},
      {"POST", "/v1/jobs", std::string(5u << 20, ' '), json, 413, nullptr},
      {"POST", "/v1/jobs", R"({"scene":"nowhere"})", json, 422, "/scene"},
      {"POST", "/v1/jobs", R"({"scene":"box","method":"magic"})", json, 422, "/method"},
      {"POST", "/v1/jobs", R"({"scene":"box","method":"huang","guide":{"grid":100000}})", json, 422,
       "/guide/grid"},
      {"POST", "/v1/jobs", R"({"scene":"box","guide":{"grid":3}})", json, 422, "/guide/grid"},
      {"POST", "/v1/jobs", R"({"scene":"box","table":"00000000000000000000000000000000"})", json,
       422, "/table"},
      {"GET", "/v1/jobs?limit=0", "", "", 422, "/limit"},
      {"GET", "/v1/jobs?limit=1x", "", "", 422, "/limit"},
      {"GET", "/v1/jobs?before=7", "", "", 422, "/before"},
      {"GET", "/v1/jobs/j000099", "", "", 404, nullptr},
      {"GET", "/v1/jobs/nonsense", "", "", 404, nullptr},
      {"GET", "/v1/jobs/j000099/tiles", "", "", 404, nullptr},
      {"GET", "/v1/jobs/j000099/image.exr", "", "", 404, nullptr},
      {"POST", "/v1/jobs/j000099/cancel", "", json, 404, nullptr},
      {"GET", "/v1/events?job=j000099", "", "", 404, nullptr},
      {"GET", "/v1/nothing", "", "", 404, nullptr},
      {"POST", "/v1/fields", "{}", json, 405, nullptr},
  };
  for (const Wrong& c : cases) {
    httplib::Client client = s_.client();
    const httplib::Result answer =
        std::string(c.method) == "POST" ? client.Post(c.path, c.body, c.type) : client.Get(c.path);
    ASSERT_TRUE(answer) << c.path << " " << c.body.substr(0, 100);
    EXPECT_EQ(answer->status, c.status) << c.path << " " << c.body.substr(0, 100);
    EXPECT_EQ(answer->get_header_value("Content-Type"), "application/problem+json") << c.path;
    const Json problem = Json::parse(answer->body, nullptr, false);
    EXPECT_EQ(problem.value("status", 0), c.status) << answer->body;
    if (c.pointer) {
      EXPECT_EQ(problem["errors"][0]["pointer"], c.pointer) << answer->body;
    }
  }
  EXPECT_EQ(s_.get("/v1/jobs")["jobs"].size(), 0u);
  const std::string id = s_.submit(kTiny);
  s_.wait_end(id);
  s_.get("/v1/jobs/" + id + "/tiles?since=-1", 422);
}

}  // namespace
}  // namespace qray::server
