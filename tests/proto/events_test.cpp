#include "proto/events.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace qray::proto {
namespace {

using Json = nlohmann::json;

TEST(Events, Framing) {
  EXPECT_EQ(sse_event(7, "done", "{}"), "id: 7\nevent: done\ndata: {}\n\n");
  EXPECT_EQ(sse_comment("hi"), ": hi\n\n");
}

TEST(Events, DataIsOneLineWhateverTheTextHolds) {
  const std::string data = state_event("j1", "failed", JobError{"a\nb\r\xff", "x\n\ny"});
  EXPECT_EQ(data.find_first_of("\r\n"), std::string::npos);
  EXPECT_EQ(Json::parse(data)["error"]["where"], "x\n\ny");
}

TEST(Events, Fields) {
  const std::string parents[] = {"p"};
  EXPECT_EQ(Json::parse(state_event("j1", "queued", {})),
            (Json{{"job", "j1"}, {"state", "queued"}, {"error", nullptr}}));
  EXPECT_EQ(
      Json::parse(progress_event("j1", {0.25, 16, 1.5}, 99)),
      (Json{{"job", "j1"}, {"fraction", .25}, {"samples", 16}, {"seconds", 1.5}, {"cursor", 99}}));
  EXPECT_EQ(Json::parse(table_event("j1", "t", parents)),
            (Json{{"job", "j1"}, {"table", "t"}, {"parents", Json::array({"p"})}}));
  EXPECT_EQ(Json::parse(done_event("j1", "canceled")),
            (Json{{"job", "j1"}, {"state", "canceled"}}));
}

}  // namespace
}  // namespace qray::proto
