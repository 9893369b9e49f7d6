#include "proto/client_json.h"

#include <gtest/gtest.h>

namespace qray::proto {
namespace {

TEST(ClientJson, ReadsAJob) {
  const auto job = parse_job(R"({"id":"j000007","state":"rendering","new":1,"error":null,
      "progress":{"fraction":0.25,"samples":16,"seconds":1.5}})");
  ASSERT_TRUE(job.ok());
  EXPECT_EQ(job.value().id, "j000007");
  EXPECT_EQ(job.value().state, "rendering");
  EXPECT_EQ(job.value().fraction, 0.25);
  EXPECT_EQ(job.value().samples, 16u);
  EXPECT_EQ(job.value().seconds, 1.5);
  EXPECT_EQ(job.value().error, "");
  EXPECT_FALSE(job.value().ended());
}

TEST(ClientJson, ReadsWhyAJobFailed) {
  const auto job = parse_job(R"({"id":"j1","state":"failed","progress":null,
      "error":{"message":"expected 1..4","where":"scene.json:/ior"}})");
  ASSERT_TRUE(job.ok());
  EXPECT_TRUE(job.value().ended());
  EXPECT_EQ(job.value().error, "scene.json:/ior: expected 1..4");
}

TEST(ClientJson, RefusesWhatIsNoJob) {
  for (const char* wrong : {"", "[]", "{", R"({"id":"j1"})", R"({"id":1,"state":"failed"})"})
    EXPECT_FALSE(parse_job(wrong).ok()) << wrong;
  EXPECT_FALSE(parse_job(std::string(200'000, '[')).ok());
}

TEST(ClientJson, ReadsHints) {
  const auto hint = parse_job_hint(R"({"job":"j1","fraction":0.5,"samples":4,"seconds":2})");
  ASSERT_TRUE(hint.ok());
  EXPECT_EQ(hint.value().fraction, 0.5);
  EXPECT_EQ(hint.value().samples, 4u);
  EXPECT_EQ(hint.value().seconds, 2);
  EXPECT_FALSE(hint.value().state.has_value());
}

TEST(ClientJson, TellsAProblemWithItsFields) {
  const auto text = problem_text(R"({"title":"Wrong request","status":422,"detail":"1 field",
      "errors":[{"pointer":"/samples","detail":"expected 1..1000000, got 0"}]})");
  EXPECT_EQ(text, "Wrong request: 1 field\n  /samples: expected 1..1000000, got 0");
  EXPECT_FALSE(problem_text("<html>").has_value());
  EXPECT_FALSE(problem_text("{}").has_value());
}

}  // namespace
}  // namespace qray::proto
