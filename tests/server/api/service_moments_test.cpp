// How jobs came to be, pixel by pixel and pass by pass, over HTTP.
#include <gtest/gtest.h>

#include "server/jobs/tile_stream.h"
#include "tests/server/pictures.h"

namespace qray::server {
namespace {

using test::Json;
using test::same_bits;
using test::TestService;

Json box(const Json& changes = Json::object()) {
  Json request = {{"scene", "box"}, {"width", 32}, {"height", 24}, {"samples", 64}};
  request.update(changes);
  return request;
}

class ServiceMomentsTest : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  std::string ended(const Json& request) const {
    const std::string id = s_.submit(request);
    s_.wait_end(id);
    return id;
  }
  std::string body(const std::string& path) const {
    const auto answer = s_.client().Get(path);
    EXPECT_TRUE(answer && answer->status == 200) << path << (answer ? answer->body : "");
    return answer ? answer->body : "";
  }
  Image png(const std::string& path) const { return test::get_picture(s_, path).image; }

  TestService s_;
};

TEST_F(ServiceMomentsTest, MomentsComeNearerToAReference) {
  const std::string reference = ended(box({{"samples", 3000}, {"method", "none"}, {"seed", 9}}));
  const std::string id = ended(box({{"samples", 256}}));
  const Json metrics = s_.get("/v1/jobs/" + id + "/metrics?ref=" + reference);
  EXPECT_EQ(metrics["ref"], reference);
  EXPECT_TRUE(metrics["gate"].get<std::string>().starts_with("o"));
  const Json& moments = metrics["moments"];
  ASSERT_GT(moments.size(), 8u);
  size_t pictures = 0, tables = 0;
  for (size_t i = 0; i < moments.size(); ++i) {
    EXPECT_EQ(moments[i]["number"], i + 1);
    EXPECT_TRUE(i == 0 || moments[i]["samples"] > moments[i - 1]["samples"]) << i;
    pictures += moments[i]["picture"].get<bool>();
    tables += moments[i]["table"].get<bool>();
    EXPECT_EQ(moments[i].contains("relmse"), moments[i]["picture"].get<bool>());
  }
  EXPECT_GT(pictures, 7u);
  EXPECT_GT(tables, 3u);
  EXPECT_LT(tables, pictures);
  EXPECT_EQ(moments.back()["samples"], 256);
  EXPECT_GT(moments.back()["states"], 0);
  EXPECT_GT(moments.front()["relmse"], 10 * moments[pictures - 1]["relmse"].get<double>());
  EXPECT_GT(moments[3]["noise"], moments.back()["noise"]);
  // Without a guide there is no gate, and no table.
  const Json plain = s_.get("/v1/jobs/" + reference + "/metrics");
  EXPECT_TRUE(plain["gate"].is_null());
  EXPECT_GT(plain["moments"].back()["noise"], 0);
  for (const Json& moment : plain["moments"]) EXPECT_FALSE(moment["table"]);
  s_.get("/v1/jobs/" + id + "/metrics?ref=x", 422);
  s_.get("/v1/jobs/" + id + "/metrics?ref=j000099", 404);
  s_.get("/v1/jobs/j000099/metrics", 404);
}

TEST_F(ServiceMomentsTest, AMomentsPictureIsThatOfAJobWithItsSamples) {
  const std::string id = ended(box({{"samples", 12}, {"method", "none"}}));
  const Json moments = s_.get("/v1/jobs/" + id + "/metrics")["moments"];
  const Json& early = moments[2];
  ASSERT_TRUE(early["picture"]);
  const std::string shorter = ended(box({{"samples", early["samples"]}, {"method", "none"}}));
  const std::string base = "/v1/jobs/" + id, at = "moment=3";
  const std::string tiles = body(base + "/tiles?" + at);
  EXPECT_EQ(decode_tiles(Bytes(tiles.begin(), tiles.end())).value().image.width(), 32);
  const std::string same_tiles = body("/v1/jobs/" + shorter + "/tiles");
  const auto image_of = [](const std::string& answer) {
    return decode_tiles(Bytes(answer.begin(), answer.end())).value().image;
  };
  EXPECT_TRUE(same_bits(image_of(tiles), image_of(same_tiles)));
  EXPECT_FALSE(same_bits(image_of(tiles), image_of(body(base + "/tiles"))));
  EXPECT_FALSE(same_bits(png(base + "/image.png?" + at), png(base + "/image.png")));
  const Json apart = s_.get("/v1/compare?a=" + id + "&b=" + shorter)["difference"];
  const Json near = s_.get("/v1/compare?a=" + id + "&a_moment=3&b=" + shorter)["difference"];
  EXPECT_GT(apart["relmse"], 1e-3);
  EXPECT_LT(near["relmse"], 1e-5);  // what RGB9E5 rounds off
  s_.get(base + "/tiles?moment=99", 404);
  s_.get(base + "/image.png?moment=0", 422);
  s_.get(base + "/image.png?moment=1&picture=recovered", 422);
}

TEST_F(ServiceMomentsTest, MapsShowWherePicturesDiffer) {
  const std::string few = ended(box({{"samples", 2}})), more = ended(box());
  const std::string small = ended(box({{"width", 16}}));
  for (const char* map : {"signed", "flip", "relative"}) {
    const std::string to = std::string("&map=") + map;
    const Image differ = png("/v1/compare.png?a=" + few + "&b=" + more + to);
    const Image equal = png("/v1/compare.png?a=" + few + "&b=" + few + to);
    EXPECT_EQ(differ.width(), 32);
    EXPECT_FALSE(same_bits(differ, equal)) << map;
    s_.get("/v1/compare.png?a=" + few + "&b=" + small + to, 422);
  }
  EXPECT_EQ(s_.get("/v1/compare.png?a=" + few + "&b=" + more, 422)["errors"][0]["pointer"], "/map");
  EXPECT_EQ(s_.get("/v1/compare.png?a=" + few + "&map=flip", 422)["errors"][0]["pointer"], "/b");
}

TEST_F(ServiceMomentsTest, APixelSaysWhatIsKnownThere) {
  for (const std::string method : {"huang", "adaptive", "ppg", "dahm-keller", "none"}) {
    const std::string id = ended(box({{"method", method}, {"samples", 128}}));
    const Json pixel = s_.get("/v1/jobs/" + id + "/pixel?x=16&y=18");
    const auto samples = pixel["samples"].get<double>();
    if (method == "adaptive") {
      EXPECT_GT(samples, 40);  // by noise, 128 on average
    } else {
      EXPECT_EQ(samples, 128) << method;
    }
    EXPECT_GT(pixel["radiance"][1], 0) << method;
    EXPECT_GT(pixel["variance"], 0) << method;
    const auto error = pixel["standard_error"].get<double>();
    EXPECT_NEAR(error * error * samples, pixel["variance"].get<double>(),
                1e-3 * pixel["variance"].get<double>())
        << method;
    EXPECT_NEAR(pixel["surface"]["normal"][1].get<double>(), 1, 1e-4) << method;  // the floor
    EXPECT_EQ(pixel["state"].is_null(), method == "none");
    if (pixel["state"].is_null()) continue;
    EXPECT_GT(pixel["state"]["size"], 0) << method;
    const Json& lobe = pixel["lobe"];
    EXPECT_GE(lobe["directions"].size(), 4u) << method;
    EXPECT_EQ(lobe["cells"].is_null(), method == "huang");
    const Json nothing = s_.get("/v1/jobs/" + id + "/pixel?x=0&y=0");  // past the box
    EXPECT_TRUE(nothing["surface"].is_null() && nothing["state"].is_null()) << method;
  }
  const std::string base = "/v1/jobs/j000001/pixel?x=";
  EXPECT_EQ(s_.get(base + "32&y=0", 422)["errors"][0]["pointer"], "/x");
  EXPECT_EQ(s_.get(base + "3", 422)["errors"][0]["pointer"], "/y");
  EXPECT_NE(s_.get(base + "16&y=18&moment=1")["radiance"], s_.get(base + "16&y=18")["radiance"]);
  EXPECT_EQ(s_.get(base + "16&y=18&moment=1")["samples"], 1);
  s_.get(base + "1&y=1&moment=99", 404);
}

TEST_F(ServiceMomentsTest, WhatWasLearnedIsShownWhileAJobRuns) {
  const std::string id = s_.submit(box({{"samples", 1'000'000}}));
  const std::string base = "/v1/jobs/" + id;
  Json moments;
  for (int i = 0; i < 2000; ++i) {
    moments = s_.get(base + "/metrics")["moments"];
    if (!moments.empty() && moments.back()["number"] > 6) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_GT(moments.size(), 6u);
  EXPECT_EQ(png(base + "/view.png?view=state").width(), 32);
  EXPECT_EQ(png(base + "/view.png?view=samples").width(), 32);
  EXPECT_EQ(png(base + "/view.png?view=noise").height(), 24);
  EXPECT_FALSE(s_.get(base + "/pixel?x=16&y=18")["state"].is_null());
  EXPECT_FALSE(
      same_bits(png(base + "/lobe.png?x=16&y=18&moment=1"), png(base + "/lobe.png?x=16&y=18")));
  s_.post(base + "/cancel", "", 202);
  s_.wait_end(id);
  // Noise was known while it ran; the picture that was canceled has kept it.
  EXPECT_EQ(png(base + "/view.png?view=noise").height(), 24);
}

TEST_F(ServiceMomentsTest, IsThatOfTheWholeJobWhateverHappenedToIt) {
  const std::string id = ended(box({{"samples", 16}}));
  const std::string base = "/v1/jobs/" + id;
  const Json before = s_.get(base + "/metrics")["moments"];
  s_.post(base + "/extend", R"({"samples":48})", 202);
  s_.wait_end(id);
  const Json after = s_.get(base + "/metrics")["moments"];
  ASSERT_GT(after.size(), before.size());
  for (size_t i = 0; i + 1 < before.size(); ++i) EXPECT_EQ(after[i], before[i]);
  EXPECT_EQ(after.back()["samples"], 64);
  s_.stop();
  s_.start();
  EXPECT_EQ(s_.get(base + "/metrics")["moments"], after);
  EXPECT_EQ(s_.client().Delete(base)->status, 204);
  EXPECT_FALSE(std::filesystem::exists(s_.config.data / "moments" / id));
}

TEST_F(ServiceMomentsTest, JobsOfATableAreListed) {
  const std::string first = ended(box({{"method", "huang"}}));
  const std::string second = ended(box({{"method", "huang"}}));
  const std::string other = ended(box({{"method", "huang"}, {"table", "none"}}));
  const std::string table = s_.get("/v1/jobs/" + first)["table_out"];
  const Json jobs = s_.get("/v1/jobs?table=" + table)["jobs"];
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0]["id"], second);
  EXPECT_EQ(jobs[0]["table_in"], table);
  EXPECT_EQ(jobs[1]["id"], first);
  EXPECT_EQ(s_.get("/v1/jobs?table=x", 422)["errors"][0]["pointer"], "/table");
}

}  // namespace
}  // namespace qray::server
