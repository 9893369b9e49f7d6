#include "core/cmd/event_reader.h"

#include <gtest/gtest.h>

namespace qray::cmd {
namespace {

const std::string kStream =
    ": hello\n\n"
    "id: 7\r\nevent: progress\r\ndata: {\"a\":1}\r\n\r\n"
    "data:one\ndata: two\n\n"
    "event: state\n\n"  // no data: no event
    "id: 9\nevent: done\ndata: {}\n\n";

void expect_the_three(const std::vector<ServerEvent>& events) {
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].id, "7");
  EXPECT_EQ(events[0].type, "progress");
  EXPECT_EQ(events[0].data, "{\"a\":1}");
  EXPECT_EQ(events[1].id, "7");
  EXPECT_EQ(events[1].type, "message");
  EXPECT_EQ(events[1].data, "one\ntwo");
  EXPECT_EQ(events[2].id, "9");
  EXPECT_EQ(events[2].type, "done");
  EXPECT_EQ(events[2].data, "{}");
}

TEST(EventReader, CutsAStreamIntoEvents) {
  EventReader reader;
  expect_the_three(reader.feed(kStream));
  EXPECT_EQ(reader.last_id(), "9");
}

TEST(EventReader, TakesBytesHoweverTheyArrive) {
  EventReader reader;
  std::vector<ServerEvent> events;
  for (char c : kStream)
    for (ServerEvent& event : reader.feed({&c, 1})) events.push_back(std::move(event));
  expect_the_three(events);
}

TEST(EventReader, ForgetsALineWithoutEnd) {
  EventReader reader;
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(reader.feed(std::string(1024, 'x')).empty());
  const auto events = reader.feed("\n\ndata: {}\n\n");
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].data, "{}");
}

}  // namespace
}  // namespace qray::cmd
