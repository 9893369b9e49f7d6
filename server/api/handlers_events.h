// GET /v1/events: server-sent events, from the event log to each reader at the reader's own pace.
// Any thread; a stream holds its connection's thread and one of a bounded number of places.
#pragma once

#include <atomic>

#include "server/http/router.h"
#include "server/store/event_log.h"
#include "server/store/job_store.h"

namespace qray::server {

class EventHandlers {
 public:
  static constexpr size_t kMaxStreams = 256;  // half of the connections

  EventHandlers(const EventLog& log, const JobStore& jobs, size_t max_streams = kMaxStreams)
      : log_(log), jobs_(jobs), max_streams_(max_streams) {}
  void add_to(Router& router);
  size_t stream_count() const { return *open_; }

 private:
  void stream(const httplib::Request& req, httplib::Response& res);

  const EventLog& log_;
  const JobStore& jobs_;
  const size_t max_streams_;
  // Shared with the streams, whose last act is to count themselves out.
  std::shared_ptr<std::atomic<size_t>> open_ = std::make_shared<std::atomic<size_t>>(0);
};

}  // namespace qray::server
