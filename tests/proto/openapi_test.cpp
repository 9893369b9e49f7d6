#include "proto/openapi.h"
#include "tests/support/places.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace qray::proto {
namespace {

using Json = nlohmann::json;

Json converted(std::string_view yaml) {
  const Result<std::string> json = openapi_to_json(yaml);
  EXPECT_TRUE(json.ok()) << json.error().text();
  return json.ok() ? Json::parse(json.value()) : Json();
}

TEST(OpenApi, PlainScalarsHaveTheirTypes) {
  const Json json = converted(R"(
none: [null, ~, Null]
empty:
yes: [true, False]
whole: [0, -12, +7, 0x1f, 0o17, 18446744073709551615]
real: [0.5, -1e3, .5, 2.]
text: [on, 1.2.3, 0xg, "12", 'true', "null", e, -, 1-2]
200: a key
folded: >-
  two
  lines
)");
  EXPECT_EQ(json["none"], Json::parse("[null,null,null]"));
  EXPECT_TRUE(json["empty"].is_null());
  EXPECT_EQ(json["yes"], Json::parse("[true,false]"));
  EXPECT_EQ(json["whole"], Json::parse("[0,-12,7,31,15,18446744073709551615]"));
  EXPECT_EQ(json["real"], Json::parse("[0.5,-1000.0,0.5,2.0]"));
  EXPECT_EQ(json["text"], Json::parse(R"(["on","1.2.3","0xg","12","true","null","e","-","1-2"])"));
  EXPECT_EQ(json["200"], "a key");
  EXPECT_EQ(json["folded"], "two lines");
}

TEST(OpenApi, WhatJsonCannotSayNamesItsLine) {
  for (const char* wrong : {"a: 1\nb: [", "a: 1\na: 2", "a: 1\nb: .inf", "a: 1\nb: -.INF"}) {
    const Result<std::string> json = openapi_to_json(wrong);
    ASSERT_FALSE(json.ok()) << wrong;
    EXPECT_EQ(json.error().where, "openapi.yaml:2") << wrong << ": " << json.error().text();
  }
}

TEST(OpenApi, TheContractItself) {
  std::stringstream yaml;
  yaml << std::ifstream(test::source_dir() / "proto/openapi.yaml").rdbuf();
  const Json json = converted(yaml.str());
  EXPECT_EQ(json["openapi"], "3.1.0");
  EXPECT_EQ(json["info"]["version"], "1");
  EXPECT_TRUE(json["paths"]["/v1/jobs"]["post"]["responses"].contains("202"));
  const Json& request = json["components"]["schemas"]["JobRequest"]["properties"];
  EXPECT_EQ(request["seed"]["maximum"], UINT64_MAX);
  EXPECT_EQ(request["learning_samples"]["default"], 1000000);
}

}  // namespace
}  // namespace qray::proto
