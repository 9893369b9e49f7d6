// An order of requests, and what becomes of them: several clients ask one server for things about
// a few jobs, while the server is killed, started again, finds its disk full and its clock turned.
// The server is the real runner on the real store; only the renderer is not real. Each life of the
// server is a process of its own, in which a seed says which thread goes on when (scheduler.h).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace qray::server::test {

enum class Act {
  kSubmit,  // job `job`, of `value` samples
  kPause,
  kResume,
  kCancel,
  kRemove,
  kExtend,     // by `value` samples
  kExpire,     // what ended more than a day ago goes
  kTurnClock,  // by `value` hours
  kFullDisk,
  kRoomAgain,
  kSleep,  // `value` tenths of a second
  kStop,   // in order, and another start
  kKill,   // and another start
  kCount
};

std::string_view to_string(Act act);

struct Step {
  Act act = Act::kSleep;
  int job = 0, value = 0;
};

struct Order {
  static constexpr int kClients = 3, kJobs = 3;
  uint64_t seed = 0;  // of the schedule
  int at_once = 1, max_queued = 10;
  std::vector<Step> steps[kClients];

  std::string text() const;
};

Order random_order(uint64_t seed);

// What is wrong; empty: nothing.
std::string try_order(const Order& order);

// The smallest order found that fails too, by leaving steps out.
Order shrunk(Order order);

}  // namespace qray::server::test
