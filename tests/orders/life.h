// One life of a server among several that an order of requests gives it, each in a process of its
// own, and what outlives them: the data folder, and what was asked and answered.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

#include "tests/orders/order.h"

namespace qray::server::test {

// What was asked for one job, and what was answered. In memory that outlives the server.
struct Asked {
  bool submit_begun = false, accepted = false;
  uint64_t id = 0;
  int samples = 0;                              // that it must end with
  int maybe_more = 0;                           // by extensions that were not answered
  bool cancel_begun = false, canceled = false;  // canceled: at once, as it did not run
  bool cancel_answered = false;
  bool remove_begun = false, removed = false;
};

struct Shared {
  int next_step[Order::kClients] = {};
  Asked jobs[Order::kJobs];
  bool expire_begun = false, disk_was_full = false;
  bool kill_begun = false, settled = false, ended = false;
  int kills = 0;
  std::atomic<int64_t> clock_hours = 0;
  char failure[4096] = {};
};

Shared& shared();
// Adds to what is wrong.
void fail(const std::string& text);

// Serves what is left of the order's steps, then ends the process; the last life judges.
[[noreturn]] void live(const Order& order, int life);

}  // namespace qray::server::test
