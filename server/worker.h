// A process that only runs jobs of a store that it shares with others (`qrayd worker`). Start and
// stop from one thread.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "server/operation/config.h"

namespace qray::server {

class Worker {
 public:
  // kInvalid: the configuration names no such store.
  static Result<std::unique_ptr<Worker>> start(const Config& config);
  ~Worker();
  // It was asked to take no more jobs, and those that it had have ended.
  bool is_drained() const;
  // Its jobs go back to the queue, with what they have so far.
  void stop();

 private:
  struct Parts;
  explicit Worker(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace qray::server
