// Tells webhooks of jobs' ends, on a thread of its own, until each has answered or a day is over.
// What it sends is signed; where it sends was looked up once, judged, and is what it connects to.
#pragma once

#include <thread>

#include "server/store/job_store.h"
#include "server/store/webhook_store.h"
#include "server/webhooks/addresses.h"

namespace qray::server {

// HMAC-SHA-256 of "<seconds>.<body>", as hex digits.
std::string webhook_signature(const std::string& secret, int64_t seconds, std::string_view body);

class WebhookSender {
 public:
  struct Limits {
    bool private_addresses = false;                     // may be sent to
    std::chrono::milliseconds try_takes{10'000};        // at most, of all
    std::chrono::milliseconds first_delay{2000};        // after a failure; twice that after two
    std::chrono::milliseconds gives_up{24 * 3600'000};  // after a job's end
  };
  WebhookSender(WebhookStore& webhooks, const JobStore& jobs, const Limits& limits,
                std::function<int64_t()> now_ms);
  ~WebhookSender() { stop(); }
  void stop();

 private:
  void send_due(const std::stop_token& stop);
  // Until it was taken, or why not. Of a job that was deleted there is nothing to tell.
  Status send(const Delivery& delivery, const std::stop_token& stop);
  void settle(const Delivery& delivery, const Status& sent);

  WebhookStore& webhooks_;
  const JobStore& jobs_;
  const Limits limits_;
  const std::function<int64_t()> now_ms_;
  std::jthread thread_;
};

}  // namespace qray::server
