#include "tests/orders/order.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <random>
#include <utility>

#include "tests/crash/faults.h"
#include "tests/orders/ground.h"
#include "tests/orders/life.h"

namespace qray::server::test {
namespace {

using qray::test::fault_plan;

constexpr const char* kActs[] = {
    "submit",         "pause",     "resume",     "cancel", "remove", "extend", "expire",
    "turn the clock", "full disk", "room again", "sleep",  "stop",   "kill"};
static_assert(std::size(kActs) == static_cast<size_t>(Act::kCount));

}  // namespace

std::string_view to_string(Act act) { return kActs[static_cast<int>(act)]; }

std::string Order::text() const {
  std::string out = "seed " + std::to_string(seed) + ", " + std::to_string(at_once) +
                    " at once, a queue of " + std::to_string(max_queued) + "\n";
  for (int c = 0; c < kClients; ++c) {
    out += "  client " + std::to_string(c) + ":";
    for (const Step& step : steps[c])
      out += " " + std::string(to_string(step.act)) + "(" + std::to_string(step.job) + "," +
             std::to_string(step.value) + ")";
    out += "\n";
  }
  return out;
}

Order random_order(uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto choice = [&](int most) {
    return static_cast<int>(random() % static_cast<uint64_t>(most));
  };
  Order order;
  order.seed = seed;
  order.at_once = 1 + choice(2);
  order.max_queued = choice(4) == 0 ? 1 : 10;
  // How many of each are in a bag that steps are drawn from.
  constexpr int kShares[] = {3, 6, 6, 2, 2, 3, 1, 1, 1, 2, 6, 1, 1};
  static_assert(std::size(kShares) == static_cast<size_t>(Act::kCount));
  std::vector<Act> bag;
  for (size_t a = 0; a < std::size(kShares); ++a) bag.insert(bag.end(), kShares[a], Act(a));
  // Half of the orders are about one job alone, where requests meet more often.
  const int jobs = choice(2) == 0 ? 1 : Order::kJobs;
  for (int c = 0; c < Order::kClients; ++c) {
    if (c < jobs) order.steps[c].push_back({Act::kSubmit, c, 1 + choice(8)});
    for (int n = 2 + choice(6); n > 0; --n) {
      Step step{bag[static_cast<size_t>(choice(static_cast<int>(bag.size())))], choice(jobs),
                1 + choice(8)};
      if (step.act == Act::kTurnClock) step.value = choice(100) - 30;
      order.steps[c].push_back(step);
    }
  }
  return order;
}

std::string try_order(const Order& order) {
  Ground::instance().make_anew();
  new (&shared()) Shared;
  fault_plan().armed = false;
  constexpr int kMostLives = 100;
  for (int life = 0; life < kMostLives && !shared().ended; ++life) {
    if (life > 0) Ground::instance().end_leases();
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child == 0) live(order, life);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status) &&
        !(WTERMSIG(status) == SIGKILL && std::exchange(shared().kill_begun, false)))
      fail("the server ended by signal " + std::to_string(WTERMSIG(status)));
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
      fail("the server ended with code " + std::to_string(WEXITSTATUS(status)));
    if (shared().failure[0] != '\0') break;
  }
  if (!shared().ended && shared().failure[0] == '\0') fail("it comes to no end");
  return shared().failure;
}

Order shrunk(Order order) {
  constexpr uint64_t kSchedules = 10;  // of fewer steps, another one may be what fails
  const auto fails = [&](Order& smaller) {
    for (uint64_t s = 0; s < kSchedules; ++s) {
      smaller.seed = order.seed + s;
      if (!try_order(smaller).empty()) return true;
    }
    return false;
  };
  for (bool again = true; again;) {
    again = false;
    for (std::vector<Step>& steps : order.steps)
      for (size_t i = 0; i < steps.size();) {
        const Order before = order;
        steps.erase(steps.begin() + static_cast<ptrdiff_t>(i));
        Order smaller = order;
        if (fails(smaller)) {
          order = smaller;
          again = true;
        } else {
          order = before;
          ++i;
        }
      }
  }
  return order;
}

}  // namespace qray::server::test
