// Weights over HTTP, and jobs whose pictures are recovered with them.
#include <gtest/gtest.h>

#include "core/base/file.h"
#include "core/recover/pyramid.h"
#include "core/recover/weights_file.h"
#include "tests/server/pictures.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

std::string weights_body(uint64_t seed) {
  WeightsFile w;
  w.program = "test";
  w.scene = "box";
  w.steps = 7;
  w.held_out = {0.5f, 0.25f};
  w.network = untrained_network(seed);
  w.id = weights_id(w);
  const Bytes bytes = encode_weights(w);
  return {bytes.begin(), bytes.end()};
}

class ServiceWeights : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  static Json request(const Json& changes = Json::object()) {
    Json request = {{"scene", "box"},   {"width", 24},         {"height", 24},     {"samples", 2},
                    {"method", "none"}, {"pixels", "quarter"}, {"recover", "auto"}};
    request.update(changes);
    return request;
  }
  std::string upload(const std::string& body, int status = 201) const {
    const auto answer = s_.client().Post("/v1/weights", body, "application/octet-stream");
    EXPECT_TRUE(answer);
    EXPECT_EQ(answer->status, status) << answer->body;
    return answer->status == 201 ? Json::parse(answer->body).value("id", "") : "";
  }
  int status_of(const std::string& path) const { return s_.client().Get(path)->status; }
  std::filesystem::path file(const std::string& id) const {
    return s_.config.data / "weights" / (id + ".qrw");
  }
  TestService s_;
};

TEST_F(ServiceWeights, WhatIsUploadedIsListedServedAndDeleted) {
  const std::string body = weights_body(1), id = upload(body);
  EXPECT_EQ(upload(body), id) << "the same again";
  const Json info = s_.get("/v1/weights/" + id);
  EXPECT_EQ(info["scene"], "box");
  EXPECT_EQ(info["views"], 2);
  EXPECT_EQ(info["held_out"], 0.375);
  EXPECT_EQ(info["bytes"], body.size());
  EXPECT_EQ(s_.get("/v1/weights")["weights"], Json::array({info}));
  EXPECT_EQ(s_.client().Get("/v1/weights/" + id + "/file")->body, body);
  EXPECT_EQ(s_.client().Delete("/v1/weights/" + id)->status, 204);
  EXPECT_EQ(status_of("/v1/weights/" + id), 404);
  EXPECT_FALSE(std::filesystem::exists(file(id)));
}

TEST_F(ServiceWeights, WhatIsNoWeightsFileIsRefused) {
  std::string damaged = weights_body(1);
  damaged[damaged.size() / 2] ^= 1;
  upload(damaged, 422);
  upload("", 422);
  upload(std::string(size_t{2} << 20, 'x'), 413);
  EXPECT_EQ(s_.client().Post("/v1/weights", damaged, "text/plain")->status, 415);
  EXPECT_TRUE(s_.get("/v1/weights")["weights"].empty());
}

TEST_F(ServiceWeights, AJobsPictureIsRecoveredAndItsSamplesStayThere) {
  const Json job = s_.wait_end(s_.submit(request()));
  ASSERT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_EQ(job["stats"]["recovery"], "default");
  EXPECT_EQ(job["stats"]["pixels"], "quarter");
  EXPECT_TRUE(job["biased"]);
  const std::string path = "/v1/jobs/" + job["id"].get<std::string>();
  const auto pixels = [&](const std::string& query) {
    return test::get_picture(s_, path + "/image.exr" + query).image;
  };
  const Image sampled = pixels("?picture=sampled"), recovered = pixels("");
  int black = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      if (x % 2 || y % 2) {
        EXPECT_EQ(sampled.rgb(x, y), Rgb{});
      }
      black += recovered.rgb(x, y) == Rgb{};
    }
  EXPECT_LT(black, 24 * 24 / 4);
  const Json pixel = s_.get(path + "/pixel?x=5&y=17");
  for (int c = 0; c < 3; ++c)
    EXPECT_FLOAT_EQ(pixel["radiance"][static_cast<size_t>(c)].get<float>(), recovered.at(5, 17, c));
  EXPECT_EQ(status_of(path + "/image.png?picture=recovered"), 200);
  EXPECT_EQ(status_of(path + "/tiles?since=0&picture=recovered"), 200);
  EXPECT_NE(s_.client().Get(path + "/tiles?since=0")->body,
            s_.client().Get(path + "/tiles?since=0&picture=recovered")->body);
  EXPECT_EQ(status_of(path + "/image.png?picture=both"), 422);
  const Json plain = s_.wait_end(s_.submit(request({{"recover", "none"}})));
  EXPECT_EQ(
      status_of("/v1/jobs/" + plain["id"].get<std::string>() + "/image.exr?picture=recovered"),
      404);
}

TEST_F(ServiceWeights, AJobMayNameWeightsAndDoesWithoutWhenTheyAreBroken) {
  const std::string id = upload(weights_body(2));
  EXPECT_EQ(s_.wait_end(s_.submit(request({{"recover", id}})))["stats"]["recovery"], id);
  const std::string bytes = "broken";
  ASSERT_TRUE(
      write_file_atomic(file(id), {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()})
          .ok());
  const Json job = s_.wait_end(s_.submit(request({{"recover", id}})));
  EXPECT_EQ(job["state"], "succeeded");
  EXPECT_EQ(job["stats"]["recovery"], "untrained");
  EXPECT_NE(job["warnings"].dump().find(id), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(s_.config.data / "quarantine" / (id + ".qrw")));
  s_.post("/v1/jobs", request({{"recover", id}}).dump(), 422);
}

TEST_F(ServiceWeights, AQuarterOfAnOddPictureIsRefused) {
  const Json problem = s_.post("/v1/jobs", request({{"width", 25}}).dump(), 422);
  EXPECT_EQ(problem["errors"][0]["pointer"], "/width");
}

}  // namespace
}  // namespace qray::server
