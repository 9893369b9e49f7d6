// Who wants to be told of jobs' ends, and what has not been told yet. A store of jobs adds to the
// latter with each move that ends a job, in its transaction. Each call is a transaction, durable
// when it returns. Any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/model/job.h"

namespace qray::server {

struct Webhook {
  uint64_t id = 0;
  std::string url, secret;
  int64_t created_ms = 0;
  uint64_t failures = 0;  // of the last tries, one after the other
  uint64_t waiting = 0;   // jobs' ends that it has not been told
};

struct Delivery {
  uint64_t id = 0;
  Webhook webhook;
  JobId job;
  int64_t created_ms = 0;  // when the job ended
};

class WebhookStore {
 public:
  static constexpr size_t kMost = 16;
  static constexpr size_t kMostWaiting = 10'000;  // of one webhook; then it misses ends
  static constexpr int64_t kLongestDelayMs = 3600 * 1000;

  virtual ~WebhookStore() = default;

  virtual Result<Webhook> add(const std::string& url, const std::string& secret) = 0;  // kConflict
  virtual Result<std::vector<Webhook>> list() const = 0;  // the oldest first
  virtual Status remove(uint64_t id) = 0;                 // and what waits for it; kNotFound

  // The oldest that is due. One that failed holds up the others of its webhook, and nobody else's.
  virtual Result<std::optional<Delivery>> next() const = 0;
  virtual Status delivered(const Delivery& delivery) = 0;
  virtual Status failed(const Delivery& delivery, int64_t delay_ms) = 0;
  virtual Status give_up(const Delivery& delivery) = 0;
};

}  // namespace qray::server
