// Answers of the contract that no other test meets. TestService's client compares each with it.
#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::TestService;

TEST(ServiceContract, PicturesThatAreNotThere) {
  TestService s;
  s.start();
  const std::string id = s.submit({{"scene", "box"},
                                   {"width", 32},
                                   {"height", 32},
                                   {"samples", 1'000'000},
                                   {"pixels", "quarter"},
                                   {"recover", "untrained"}});
  s.get("/v1/jobs/" + id + "/tiles?picture=recovered", 409);
  s.get("/v1/jobs/" + id + "/image.exr?picture=recovered", 409);
  for (const char* kind : {"tiles", "image.exr", "image.png"}) {
    const auto problem = s.get("/v1/jobs/" + id + "/" + kind + "?picture=best", 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/picture") << kind;
  }
  s.post("/v1/jobs/" + id + "/cancel", "", 202);
  s.wait_end(id);
}

TEST(ServiceContract, WhatIsTooLarge) {
  TestService s;
  s.config.asset_mib = 1;
  s.config.json_mib = 1;
  s.start();
  const std::string body(1'100'000, ' ');
  for (const char* path : {"/v1/scenes", "/v1/tables/merge", "/v1/session", "/v1/weights"})
    s.post(path, body, 413);
  const auto put =
      s.client().Put("/v1/assets/" + std::string(64, '0'), body, "application/octet-stream");
  EXPECT_EQ(put->status, 413);
}

}  // namespace
}  // namespace qray::server
