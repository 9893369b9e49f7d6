#include "server/api/handlers_events.h"

#include <charconv>

#include "proto/events.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

using std::chrono::steady_clock;
constexpr std::chrono::milliseconds kLookForEvent{1000};  // how soon a reader that left is noticed
constexpr std::chrono::seconds kHeartbeat{10};
constexpr size_t kMaxWrite = 64 * 1024;

struct EventReader {
  uint64_t cursor = 0;
  std::string job;
  bool greeted = false;
  steady_clock::time_point last_write{};
};

bool send(httplib::DataSink& sink, EventReader& reader, const std::string& text) {
  reader.last_write = steady_clock::now();
  return sink.write(text.data(), text.size());
}

// One round: what is new, or a comment when it was quiet for long. False: the reader has gone.
bool pump(const EventLog& log, EventReader& reader, httplib::DataSink& sink) {
  if (!reader.greeted) {
    reader.greeted = true;
    if (!send(sink, reader, "retry: 1000\n" + proto::sse_comment("qray"))) return false;
  }
  if (log.closed()) {
    sink.done();
    return true;
  }
  EventLog::Batch batch = log.wait(reader.cursor, reader.job, kLookForEvent);
  reader.cursor = batch.cursor;
  std::string text;
  if (batch.reset) text = proto::sse_event(batch.cursor, "reset", "{}");
  for (const Event& event : batch.events) {
    text += proto::sse_event(event.id, event.kind, event.data);
    if (text.size() < kMaxWrite) continue;
    if (!send(sink, reader, text)) return false;
    text.clear();
  }
  if (text.empty() && steady_clock::now() - reader.last_write >= kHeartbeat) {
    text = proto::sse_comment("still here");
  }
  return text.empty() ? sink.is_writable() : send(sink, reader, text);
}

// Where to go on; an id that is no number is none of ours, and so leads to `reset`.
uint64_t cursor_of(const httplib::Request& req, uint64_t newest) {
  std::string text = req.get_header_value("Last-Event-ID");
  if (text.empty()) text = req.get_param_value("after");
  if (text.empty()) return newest;
  uint64_t id = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, id);
  return error == std::errc{} && stop == end ? id : UINT64_MAX;
}

}  // namespace

void EventHandlers::add_to(Router& router) {
  router.add("GET", "/v1/events", [this](auto& req, auto& res, auto&) { stream(req, res); });
}

void EventHandlers::stream(const httplib::Request& req, httplib::Response& res) {
  auto reader = std::make_shared<EventReader>();
  if (req.has_param("job")) {
    reader->job = req.get_param_value("job");
    const Result<JobRecord> job = jobs_.find(reader->job);
    if (!job.ok()) return reply_error(res, job.error());
  }
  if (open_->fetch_add(1) >= max_streams_) {
    open_->fetch_sub(1);
    return reply_problem(
        res, {503, "Too many streams", "expected at most " + std::to_string(max_streams_), {}});
  }
  reader->cursor = cursor_of(req, log_.newest());
  res.status = 200;
  res.set_header("Cache-Control", "no-store");
  res.set_header("X-Accel-Buffering", "no");  // for a proxy in between
  res.set_chunked_content_provider(
      "text/event-stream",
      [&log = log_, reader](size_t, httplib::DataSink& sink) { return pump(log, *reader, sink); },
      [open = open_](bool) { open->fetch_sub(1); });
}

}  // namespace qray::server
