// Live sessions of the whole service, read as the page would.
#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using namespace std::chrono_literals;
using test::Json;
using test::RawConnection;
using test::TestService;

struct Frame {
  uint64_t number = 0, camera = 0;
  uint32_t width = 0, height = 0;
  uint8_t stage = 0;
  std::string picture;
};

template <class T>
T number_at(const std::string& bytes, size_t at) {
  T v;
  std::memcpy(&v, bytes.data() + at, sizeof v);
  return v;
}

// Reads one frame after the other from a connection's chunks.
class Frames {
 public:
  Frames(int port, const std::string& id, const std::string& query = "", int held_bytes = 0)
      : connection_(port, held_bytes) {
    connection_.send("GET /v1/live/" + id + "/frames" + query +
                     " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    head_ = connection_.read_until("\r\n\r\n");
  }
  const std::string& head() const { return head_; }
  // Nothing once the stream is over.
  std::optional<Frame> next() {
    if (!fill(88)) return {};
    Frame f;
    EXPECT_EQ(bytes_.substr(0, 4), "QRL1");
    const auto header = number_at<uint32_t>(bytes_, 4), size = number_at<uint32_t>(bytes_, 8);
    EXPECT_EQ(header, 88u);
    f.stage = static_cast<uint8_t>(bytes_[13]);
    f.number = number_at<uint64_t>(bytes_, 16);
    f.camera = number_at<uint64_t>(bytes_, 24);
    f.width = number_at<uint32_t>(bytes_, 32);
    f.height = number_at<uint32_t>(bytes_, 36);
    if (!fill(header + size)) return {};
    f.picture = bytes_.substr(header, size);
    bytes_.erase(0, header + size);
    return f;
  }
  // The first frame that shows this camera.
  std::optional<Frame> of_camera(uint64_t number) {
    for (;;) {
      std::optional<Frame> f = next();
      if (!f || f->camera >= number) return f;
    }
  }

 private:
  bool fill(size_t size) {
    while (bytes_.size() < size) {
      const std::string line = connection_.read_until("\r\n");
      const size_t chunk = std::strtoul(line.c_str(), nullptr, 16);
      if (chunk == 0) return false;
      std::string data;
      while (data.size() < chunk + 2) {
        std::string more = connection_.read_some(chunk + 2 - data.size());
        if (more.empty()) return false;
        data += more;
      }
      bytes_ += data.substr(0, chunk);
    }
    return true;
  }
  RawConnection connection_;
  std::string head_, bytes_;
};

class ServiceLiveTest : public ::testing::Test {
 protected:
  void SetUp() override {
    s_.config.live_sessions = 2;
    s_.start();
  }
  Json open(Json request = Json::object()) const {
    request["scene"] = "box";
    request["frame_ms"] = 20;
    return s_.post("/v1/live", request.dump(), 201);
  }
  Json put(const std::string& path, const Json& body, int status = 200) const {
    const auto answer = s_.client().Put(path, body.dump(), "application/json");
    EXPECT_TRUE(answer);
    if (!answer) return {};
    EXPECT_EQ(answer->status, status) << path << " " << answer->body;
    return Json::parse(answer->body, nullptr, false);
  }
  static Json camera(uint64_t number, double x) {
    return {{"number", number}, {"camera", {{"position", {x, 1, 3}}}}};
  }
  Frames frames(const std::string& id, const std::string& query = "") const {
    return {s_.service->port(), id, query};
  }
  // Until the session is not found any more.
  bool ends_within(const std::string& id, std::chrono::milliseconds time) const {
    const auto until = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < until) {
      if (s_.client().Get("/v1/live/" + id)->status == 404) return true;
      std::this_thread::sleep_for(20ms);
    }
    return false;
  }
  TestService s_;
};

TEST_F(ServiceLiveTest, ShowsWhatItsCameraSees) {
  const Json session = open();
  const std::string id = session["id"];
  EXPECT_EQ(session["width"], 48);
  EXPECT_EQ(session["lights"], Json::array({"light"}));
  EXPECT_EQ(session["camera"]["position"], Json::array({0, 1, 3}));
  Frames stream = frames(id);
  EXPECT_NE(stream.head().find("200 OK"), std::string::npos) << stream.head();
  const std::optional<Frame> first = stream.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->camera, 0u);
  EXPECT_EQ(first->picture.size(), 4u * first->width * first->height);
  EXPECT_NE(first->picture, std::string(first->picture.size(), '\0'));

  put("/v1/live/" + id + "/camera", camera(7, 0.2));
  const std::optional<Frame> moved = stream.of_camera(7);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->camera, 7u);
  EXPECT_GT(moved->number, first->number);
}

TEST_F(ServiceLiveTest, TheLatestCameraWins) {
  const std::string id = open()["id"];
  const std::string path = "/v1/live/" + id + "/camera";
  EXPECT_EQ(put(path, camera(5, 0.1))["number"], 5);
  EXPECT_EQ(put(path, camera(3, 0.9))["number"], 5);  // stale: dropped
  EXPECT_EQ(put(path, camera(5, 0.9))["number"], 5);
  EXPECT_NEAR(s_.get("/v1/live/" + id)["camera"]["position"][0].get<double>(), 0.1, 1e-6);
  EXPECT_EQ(put(path, camera(6, 0.4))["number"], 6);
  EXPECT_NEAR(s_.get("/v1/live/" + id)["camera"]["position"][0].get<double>(), 0.4, 1e-6);
}

TEST_F(ServiceLiveTest, ASlowReaderMissesFramesAndDelaysNobody) {
  // Not recovered, so that a sanitized build sends the frames before the server gives up on a
  // reader.
  const std::string id = open({{"width", 512}, {"height", 512}, {"recovery", false}})["id"];
  Frames slow(s_.service->port(), id, "", 64 << 10), quick = frames(id);
  ASSERT_TRUE(slow.next());
  uint64_t last = 0;
  for (int i = 0; i < 8; ++i) {  // 8 MB: more than its connection holds
    const std::optional<Frame> f = quick.next();
    ASSERT_TRUE(f);
    last = f->number;
  }
  uint64_t before = 0, missed = 0;
  for (;;) {
    const std::optional<Frame> f = slow.next();
    ASSERT_TRUE(f);
    if (before > 0) missed += f->number - before - 1;
    before = f->number;
    if (f->number >= last) break;
  }
  EXPECT_GT(missed, 0u);
}

TEST_F(ServiceLiveTest, AClosedTabFreesEverything) {
  const std::string id = open()["id"];
  {
    Frames stream = frames(id);
    ASSERT_TRUE(stream.next());
    EXPECT_EQ(s_.get("/v1/live/" + id)["readers"], 1);
  }
  EXPECT_TRUE(ends_within(id, 5s));
}

TEST_F(ServiceLiveTest, AReaderThatComesBackFindsTheSession) {
  const std::string id = open()["id"];
  ASSERT_TRUE(frames(id).next());
  Frames again = frames(id, "?enc=jpeg");
  const std::optional<Frame> f = again.next();
  ASSERT_TRUE(f);
  EXPECT_EQ(f->picture.substr(0, 2), "\xff\xd8");
  Frames third = frames(id, "?enc=webp");
  const std::optional<Frame> webp = third.next();
  ASSERT_TRUE(webp);
  EXPECT_EQ(webp->picture.substr(0, 4), "RIFF");
}

TEST_F(ServiceLiveTest, SessionsAreBounded) {
  const std::string first = open()["id"];
  open();
  const auto third = s_.client().Post("/v1/live", R"({"scene":"box"})", "application/json");
  EXPECT_EQ(third->status, 503);
  EXPECT_TRUE(third->has_header("Retry-After"));
  EXPECT_EQ(s_.client().Delete("/v1/live/" + first)->status, 204);
  EXPECT_TRUE(ends_within(first, 5s));
  open();
}

// The bound of memory is that of jobs; a session alone may be over it.
TEST_F(ServiceLiveTest, SessionsHaveRoomBesideEachOther) {
  s_.config.jobs_mib = 1;
  s_.stop();
  s_.start();
  const std::string first = open()["id"];
  const auto second = s_.client().Post("/v1/live", R"({"scene":"box"})", "application/json");
  EXPECT_EQ(second->status, 503);
  EXPECT_NE(second->body.find("memory"), std::string::npos) << second->body;
  EXPECT_EQ(s_.client().Delete("/v1/live/" + first)->status, 204);
  EXPECT_TRUE(ends_within(first, 5s));
  open();
}

TEST_F(ServiceLiveTest, MetricsCountFrames) {
  Frames stream = frames(open()["id"]);
  ASSERT_TRUE(stream.next());
  const std::string text = s_.client().Get("/metrics")->body;
  EXPECT_NE(text.find("qray_live_sessions 1\n"), std::string::npos) << text;
  EXPECT_NE(text.find("qray_live_frames_total"), std::string::npos);
  EXPECT_EQ(text.find("qray_live_frames_total 0\n"), std::string::npos);
  EXPECT_NE(text.find("qray_live_seconds_total{phase=\"samples\"}"), std::string::npos);
}

TEST_F(ServiceLiveTest, LeavesATableForTheNextAndStartsFromIt) {
  const std::string id = open()["id"];
  {
    Frames stream = frames(id);
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(stream.next());
  }
  ASSERT_TRUE(ends_within(id, 5s));
  const Json tables = s_.get("/v1/tables")["tables"];
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0]["scene"], "box");
  EXPECT_TRUE(tables[0]["parents"].empty());

  const Json second = open();
  EXPECT_EQ(second["table_in"], tables[0]["id"]);
  {
    Frames stream = frames(second["id"]);
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(stream.next());
  }
  ASSERT_TRUE(ends_within(second["id"], 5s));
  const Json after = s_.get("/v1/tables")["tables"];
  for (const Json& table : after)
    if (table["id"] != tables[0]["id"]) {
      EXPECT_EQ(table["parents"][0], tables[0]["id"]);
    }
  // A job starts from one of them.
  const std::string job = s_.submit({{"scene", "box"}, {"samples", 4}});
  EXPECT_NE(s_.wait_end(job)["table_in"], nullptr);
}

TEST_F(ServiceLiveTest, WallsStopACameraThatAsksForIt) {
  const std::string path = "/v1/live/" + open()["id"].get<std::string>() + "/camera";
  const auto at = [](uint64_t number, double z, bool walls) {
    return Json{{"number", number},
                {"camera", {{"position", {0, 1, z}}, {"target", {0, 1, -3}}}},
                {"walls", walls}};
  };
  EXPECT_EQ(put(path, at(1, 1, true))["position"], nullptr);
  const Json stopped = put(path, at(2, -2, true));  // the back wall is at -1
  ASSERT_TRUE(stopped["position"].is_array()) << stopped;
  EXPECT_GT(stopped["position"][2], -1);
  EXPECT_LT(stopped["position"][2], -0.9);
  EXPECT_EQ(put(path, at(3, -2, false))["position"], nullptr);
}

TEST_F(ServiceLiveTest, AJobIsLitAsTheSessionIs) {
  const std::string id = open()["id"];
  EXPECT_EQ(s_.get("/v1/live/" + id)["mix"], "1");
  const std::string mix = put("/v1/live/" + id + "/lights", {{"factors", {0.25}}})["mix"];
  EXPECT_EQ(mix, "0.25");
  const std::string job =
      s_.submit({{"scene", "box"}, {"samples", 1}, {"light_groups", "material"}, {"mix", mix}});
  EXPECT_EQ(s_.wait_end(job)["state"], "succeeded");
}

TEST_F(ServiceLiveTest, LightsAndSwitches) {
  const std::string id = open({{"table", "none"}})["id"];
  Frames stream = frames(id);
  ASSERT_TRUE(stream.next());
  EXPECT_EQ(put("/v1/live/" + id + "/switches", {{"recovery", false}})["recovery"], false);
  EXPECT_EQ(s_.get("/v1/live/" + id)["learning"], true);
  EXPECT_EQ(put("/v1/live/" + id + "/lights", {{"factors", {0}}})["factors"], Json::array({0}));
  for (int i = 0; i < 200; ++i) {
    const std::optional<Frame> f = stream.next();
    ASSERT_TRUE(f);
    if (f->picture == std::string(f->picture.size(), '\0')) return;
  }
  ADD_FAILURE() << "the light is on";
}

TEST_F(ServiceLiveTest, ErrorsNameTheField) {
  const std::string id = open()["id"];
  const auto pointer_of = [](const Json& problem) {
    return problem["errors"].empty() ? "" : problem["errors"][0].value("pointer", "");
  };
  const std::pair<const char*, const char*> bad[] = {
      {R"({"scene":"nowhere"})", "/scene"},
      {R"({"scene":"box","width":47})", "/width"},
      {R"({"scene":"box","width":8000,"height":8000})", "/width"},
      {R"({"scene":"box","frame_ms":1})", "/frame_ms"},
      {R"({"scene":"box","method":"magic"})", "/method"},
      {R"({"scene":"box","table":"00000000000000000000000000000000"})", "/table"},
      {R"({"scene":"box","recover":"bilinear"})", "/recover"},
      {R"({"scene":"box","learning":1})", "/learning"},
      {R"({"scene":"box","samples":1})", "/samples"},
      {R"({"scene":"box","camera":{"position":[0,1]}})", "/camera/position"},
  };
  for (const auto& [body, pointer] : bad)
    EXPECT_EQ(pointer_of(s_.post("/v1/live", body, 422)), pointer) << body;
  const std::string path = "/v1/live/" + id;
  EXPECT_EQ(pointer_of(put(path + "/camera", {{"camera", Json::object()}}, 422)), "/number");
  EXPECT_EQ(
      pointer_of(put(path + "/camera", {{"number", 1}, {"camera", {{"target", {0, 1, 3}}}}}, 422)),
      "/camera");
  EXPECT_EQ(pointer_of(put(path + "/lights", {{"factors", {1, 1}}}, 422)), "/factors");
  EXPECT_EQ(pointer_of(put(path + "/lights", {{"factors", {-1}}}, 422)), "/factors/0");
  EXPECT_EQ(pointer_of(put(path + "/switches", {{"magic", true}}, 422)), "/magic");
  EXPECT_EQ(s_.client().Get(path + "/frames?enc=gif")->status, 422);
  put("/v1/live/l999999/camera", camera(1, 0), 404);
  EXPECT_EQ(s_.client().Get("/v1/live/l999999/frames")->status, 404);
}

}  // namespace
}  // namespace qray::server
