// Server-sent events of the whole service, read as a browser would.
#include <gtest/gtest.h>

#include <sstream>

#include "server/api/handlers_events.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::RawConnection;
using test::TestService;

struct SseEvent {
  uint64_t id = 0;
  std::string kind;
  Json data;
};

// The events in a stream's text; the chunk framing around them is passed over.
std::vector<SseEvent> parse_events(const std::string& text) {
  std::vector<SseEvent> events;
  std::istringstream in(text);
  SseEvent event;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("id: ")) event.id = std::stoull(line.substr(4));
    if (line.starts_with("event: ")) event.kind = line.substr(7);
    if (line.starts_with("data: ")) {
      event.data = Json::parse(line.substr(6));
      events.push_back(event);
    }
  }
  return events;
}

class ServiceEventsTest : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  RawConnection open(const std::string& query, const std::string& last_event_id = "") const {
    RawConnection c(s_.service->port());
    c.send("GET /v1/events" + query + " HTTP/1.1\r\nHost: localhost\r\n" +
           (last_event_id.empty() ? "" : "Last-Event-ID: " + last_event_id + "\r\n") + "\r\n");
    const std::string begin = c.read_until(": qray\n\n");
    EXPECT_NE(begin.find("text/event-stream"), std::string::npos) << begin;
    return c;
  }
  std::string submit(int samples = 8) const {
    return s_.submit({{"scene", "box"},
                      {"width", 32},
                      {"height", 32},
                      {"samples", samples},
                      {"learning_samples", 16}});
  }
  TestService s_;
};

TEST_F(ServiceEventsTest, AJobsEventsInOrder) {
  RawConnection c = open("");
  const std::string id = submit();
  const std::vector<SseEvent> events = parse_events(c.read_until("\"succeeded\"}\n"));
  std::vector<std::string> states;
  uint64_t last = 0;
  for (const SseEvent& e : events) {
    EXPECT_GT(e.id, last);
    last = e.id;
    EXPECT_EQ(e.data["job"], id);
    if (e.kind == "state") states.push_back(e.data["state"]);
  }
  EXPECT_EQ(states, (std::vector<std::string>{"queued", "preparing", "learning", "rendering",
                                              "finalizing", "succeeded"}));
}

TEST_F(ServiceEventsTest, LastEventIdGoesOnAndOldIdsReset) {
  const std::string id = submit();
  s_.wait_end(id);
  const std::vector<SseEvent> all = parse_events(open("?after=0").read_until("\"succeeded\"}\n"));
  ASSERT_GE(all.size(), 7u);
  EXPECT_EQ(all.back().kind, "done");
  EXPECT_EQ(all[all.size() - 3].kind, "table");
  const std::vector<SseEvent> rest =
      parse_events(open("", std::to_string(all[2].id)).read_until("\"succeeded\"}\n"));
  ASSERT_EQ(rest.size(), all.size() - 3);
  EXPECT_EQ(rest[0].id, all[3].id);
  for (const char* unknown : {"999999999", "nonsense", "-1"}) {
    const std::string text = open("", unknown).read_until("event: reset\ndata: {}\n\n");
    EXPECT_NE(text.find("event: reset"), std::string::npos) << unknown << text;
  }
}

TEST_F(ServiceEventsTest, OfOneJob) {
  const std::string first = submit(), second = submit();
  s_.wait_end(second);
  RawConnection c = open("?after=0&job=" + second);
  for (const SseEvent& e : parse_events(c.read_until("\"succeeded\"}\n"))) {
    EXPECT_EQ(e.data["job"], second) << "not " << first;
  }
}

TEST_F(ServiceEventsTest, ProgressComesAtMostTwiceASecondWithTheCursor) {
  RawConnection c = open("");
  const auto begin = std::chrono::steady_clock::now();
  const std::string id = submit(1'000'000);
  std::string text;
  for (int i = 0; i < 2; ++i) text += c.read_until("\"cursor\":");
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(took, std::chrono::milliseconds(450)) << text;
  s_.post("/v1/jobs/" + id + "/cancel", "", 202);
  text += c.read_until("\"canceled\"}\n");
  EXPECT_NE(text.find("canceling"), std::string::npos);
}

TEST_F(ServiceEventsTest, StreamsAreBoundedAndFreedWhenReadersLeave) {
  {
    std::vector<RawConnection> streams;
    for (size_t i = 0; i < EventHandlers::kMaxStreams; ++i) streams.push_back(open(""));
    const auto refused = s_.client().Get("/v1/events");
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 503);
    EXPECT_TRUE(refused->has_header("Retry-After"));
    for (int i = 0; i < 32; ++i) s_.get("/healthz");
    s_.wait_end(submit());
  }
  for (int i = 0; i < 500 && s_.service->stream_count() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(s_.service->stream_count(), 0u);
  open("");
}

TEST_F(ServiceEventsTest, StopsWhileStreamsAreOpenAndAJobRuns) {
  RawConnection c = open("");
  std::vector<RawConnection> idle;
  for (int i = 0; i < 16; ++i) idle.emplace_back(s_.service->port());
  s_.wait(submit(1'000'000), {"rendering"});
  const auto begin = std::chrono::steady_clock::now();
  s_.stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
  c.read_all();  // has ended
}

}  // namespace
}  // namespace qray::server
