// Passes and groups of lights over HTTP.
#include <gtest/gtest.h>

#include <fstream>

#include "core/image/image_io.h"
#include "core/image/picture_layers.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

std::string body_of(const TestService& s, const std::string& path, const char* type) {
  const auto answer = s.client().Get(path);
  EXPECT_TRUE(answer && answer->status == 200) << path << (answer ? answer->body : "");
  EXPECT_EQ(answer ? answer->get_header_value("Content-Type") : "", type);
  return answer ? answer->body : "";
}

TEST(ServicePasses, AreLayersOfOneFileAndPicturesEach) {
  TestService s;
  s.start();
  const std::string id = s.submit(
      {{"scene", "box"},
       {"width", 40},
       {"height", 40},
       {"samples", 4},
       {"passes",
        {"normal", "depth", "direct", "indirect", "emission", "cryptomatte-object", "samples"}}});
  const Json job = s.wait_end(id);
  ASSERT_EQ(job["state"], "succeeded") << job.dump();
  EXPECT_GT(job["stats"]["picture_passes_seconds"], 0);
  const Json layers = s.get("/v1/jobs/" + id + "/passes")["layers"];
  for (const char* name : {"", "normal", "depth", "direct", "CryptoObject02", "samples"})
    EXPECT_NE(std::find(layers.begin(), layers.end(), name), layers.end()) << layers;
  const auto file = s.scratch / "passes.exr";
  std::ofstream(file, std::ios::binary)
      << body_of(s, "/v1/jobs/" + id + "/passes.exr", "image/x-exr");
  const auto part = [&](const char* name) { return read_layer(file, name).value().image; };
  const Image whole = part(""), direct = part("direct"), indirect = part("indirect"),
              emission = part("emission");
  for (size_t i = 0; i < whole.data().size(); ++i)
    ASSERT_NEAR(direct.data()[i] + indirect.data()[i] + emission.data()[i], whole.data()[i],
                1e-5f * (1 + whole.data()[i]));
  for (const Json& name : layers)
    EXPECT_EQ(
        body_of(s, "/v1/jobs/" + id + "/pass.png?layer=" + name.get<std::string>(), "image/png")
            .substr(1, 3),
        "PNG");
  s.get("/v1/jobs/" + id + "/pass.png?layer=uv", 422);
  s.get("/v1/jobs/" + id + "/pass.png?layer=normal&exposure=x", 422);
  s.get("/v1/jobs/" + id + "/passes?frame=1", 404);
}

TEST(ServicePasses, AJobWithoutThemHasNone) {
  TestService s;
  s.start();
  const std::string id = s.submit({{"scene", "box"}, {"samples", 1}});
  s.wait_end(id);
  for (const char* path : {"/passes", "/passes.exr", "/pass.png?layer=normal"})
    s.get("/v1/jobs/" + id + path, 404);
}

TEST(ServicePasses, OfFramesEachHasItsOwn) {
  TestService s;
  s.start();
  const std::string id = s.submit({{"scene", "box"},
                                   {"width", 40},
                                   {"height", 40},
                                   {"samples", 2},
                                   {"passes", {"motion"}},
                                   {"frames", {{"turntable", 2}, {"degrees", 10}}}});
  ASSERT_EQ(s.wait_end(id)["state"], "succeeded");
  EXPECT_NE(body_of(s, "/v1/jobs/" + id + "/pass.png?layer=forward&frame=0", "image/png"),
            body_of(s, "/v1/jobs/" + id + "/pass.png?layer=forward&frame=1", "image/png"));
}

TEST(ServicePasses, GroupsOfLightsAreMixedAfterwards) {
  TestService s;
  s.start();
  const std::string id = s.submit(
      {{"scene", "box"}, {"width", 40}, {"height", 40}, {"samples", 8}, {"light_groups", "each"}});
  const Json job = s.wait_end(id);
  ASSERT_EQ(job["state"], "succeeded") << job.dump();
  const std::string of = "/v1/jobs/" + id;
  const size_t groups = s.get(of + "/light-groups")["groups"].size();
  ASSERT_GE(groups, 1u);
  const auto mix = [&](const std::string& factor) {
    std::string text;
    for (size_t g = 0; g < groups; ++g) text += (g > 0 ? ";" : "") + factor;
    return text;
  };
  const auto picture = [&](const std::string& parameters) {
    const auto file = s.scratch / "mix.exr";
    std::ofstream(file, std::ios::binary)
        << body_of(s, of + "/image.exr" + parameters, "image/x-exr");
    return read_image(file).value();
  };
  const Image plain = picture(""), ones = picture("?mix=" + mix("1")),
              twice = picture("?mix=" + mix("2,0,1"));
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      const Rgb c = plain.rgb(x, y);
      ASSERT_EQ(ones.rgb(x, y), c) << "a mix of ones is the picture, to the bit";
      ASSERT_FLOAT_EQ(twice.rgb(x, y).r, 2 * c.r);
      ASSERT_EQ(twice.rgb(x, y).g, 0);
    }
  EXPECT_GT(body_of(s, of + "/tiles?group=0", "application/octet-stream").size(), 4u * 40 * 40);
  EXPECT_EQ(body_of(s, of + "/image.png?mix=" + mix("0"), "image/png").substr(1, 3), "PNG");
  s.get(of + "/tiles?group=" + std::to_string(groups), 422);
  s.get(of + "/image.png?mix=bright", 422);
  s.get(of + "/image.exr?mix=" + mix("1") + "&picture=recovered", 422);
  const std::string plain_job = s.submit({{"scene", "box"}, {"samples", 1}});
  s.wait_end(plain_job);
  EXPECT_EQ(s.get("/v1/jobs/" + plain_job + "/light-groups")["groups"], Json::array());
  s.get("/v1/jobs/" + plain_job + "/image.png?mix=1", 404);
  s.get("/v1/jobs/" + plain_job + "/tiles?group=0", 404);
}

TEST(ServicePasses, WhatIsNoPassIsRefused) {
  TestService s;
  s.start();
  const auto refused = [&](Json request, const char* pointer) {
    request["scene"] = "box";
    const Json problem = s.post("/v1/jobs", request.dump(), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], pointer) << problem;
  };
  refused({{"passes", {"normal", "beauty"}}}, "/passes/1");
  refused({{"passes", "normal"}}, "/passes");
  refused({{"light_groups", "lamp"}}, "/light_groups");
  const std::string id = s.submit({{"scene", "box"}, {"light_groups", "each"}, {"mix", "1;2;3"}});
  const Json failed = s.wait_end(id);
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_EQ(failed["error"]["where"], "/mix") << failed;
}

}  // namespace
}  // namespace qray::server
