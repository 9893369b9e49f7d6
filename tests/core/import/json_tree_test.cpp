#include "core/import/json_tree.h"

#include <gtest/gtest.h>

#include <functional>

namespace qray {
namespace {

Bytes bytes(std::string_view text) { return {text.begin(), text.end()}; }

// The error that parsing `text` ends with, as text; empty when there is none.
std::string parse_failure(std::string_view text) {
  try {
    parse_json(bytes(text), "s.json");
    return "";
  } catch (const ImportFailure& failure) {
    return failure.error.text();
  }
}

std::string nested(int levels) {
  return std::string(static_cast<size_t>(levels), '[') +
         std::string(static_cast<size_t>(levels), ']');
}

TEST(JsonTree, SyntaxErrorsNameTheLine) {
  const struct {
    const char *text, *where;
  } cases[] = {
      {"", "s.json:1"},          {"{\n\"a\": 1,\n}", "s.json:3"}, {"[1, 2\n", "s.json:2"},
      {"{\"a\" 1}", "s.json:1"}, {"[1e999]", "s.json:1"},         {"[\"\xff\"]", "s.json:1"},
      {"{} {}", "s.json:1"},     {"[NaN]", "s.json:1"},           {"[01]", "s.json:1"}};
  for (const auto& c : cases) {
    const std::string failure = parse_failure(c.text);
    EXPECT_EQ(failure.substr(0, failure.find(": ")), c.where) << c.text << " -> " << failure;
  }
}

TEST(JsonTree, DuplicateKeysAreRefusedByPlace) {
  EXPECT_EQ(parse_failure(R"({"a": [0, {"b": 1, "c": 2, "b": 3}]})"),
            "s.json:/a/1/b: appears twice");
  EXPECT_EQ(parse_failure(R"({"x/y": 1, "x/y": 2})"), "s.json:/x~1y: appears twice");
}

TEST(JsonTree, DepthIsBounded) {
  EXPECT_EQ(parse_failure(nested(kMaxJsonDepth)), "");
  const std::string failure = parse_failure(R"({"a": )" + nested(kMaxJsonDepth) + "}");
  EXPECT_NE(failure.find("s.json:/a/0/0"), std::string::npos) << failure;
  EXPECT_NE(failure.find("nested too deeply"), std::string::npos) << failure;
}

TEST(JsonTree, AHundredThousandLevelsDoNotOverflowTheStack) {
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  for (const std::string& text : {std::string(100'000, '['), nested(100'000), objects})
    EXPECT_NE(parse_failure(text).find("nested too deeply"), std::string::npos);
}

TEST(JsonNode, ChecksTypesAndNamesThePlace) {
  const JsonValue tree = parse_json(
      bytes(
          R"({"n": 2.5, "s": "text", "b": true, "o": null, "v": [1, 2, "3"], "far": [1, 2, 3e7]})"),
      "s.json");
  const JsonNode root(tree, "s.json:");
  EXPECT_EQ(root.get("n").number(), 2.5f);
  EXPECT_TRUE(root.get("b").boolean());
  const struct {
    std::function<void()> read;
    const char* error;
  } cases[] = {
      {[&] { root.get("n").integer(0, 9); }, "s.json:/n: expected an integer, 0..9, got 2.5"},
      {[&] { root.get("n").number(0, 1); }, "s.json:/n: expected 0..1, got 2.5"},
      {[&] { root.get("n").string(); }, "s.json:/n: expected a string, got 2.5"},
      {[&] { root.get("s").number(); }, "s.json:/s: expected a number, got \"text\""},
      {[&] { root.get("o").boolean(); }, "s.json:/o: expected true or false, got null"},
      {[&] { root.get("b").size(); }, "s.json:/b: expected an array, got true"},
      {[&] { root.get("v").vec3(); }, "s.json:/v/2: expected a number, got \"3\""},
      {[&] { root.get("v").numbers(2); },
       "s.json:/v: expected an array of 2 numbers, got an array of 3"},
      {[&] { root.get("far").vec3(); }, "s.json:/far/2: expected -1e+06..1e+06, got 30000000"},
      {[&] { root.get("v").get("x"); }, "s.json:/v: expected an object, got an array of 3"},
      {[&] { root.get("x"); }, "s.json: \"x\" is missing"},
      {[&] {
         root.only({"n", "s", "b", "v", "far"});
       },
       "s.json:/o: unknown field, expected one of: n, s, b, v, far"},
  };
  for (const auto& c : cases) {
    try {
      c.read();
      ADD_FAILURE() << "no error: " << c.error;
    } catch (const ImportFailure& failure) {
      EXPECT_EQ(failure.error.text(), c.error);
    }
  }
}

}  // namespace
}  // namespace qray
