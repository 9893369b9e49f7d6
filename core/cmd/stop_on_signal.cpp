#include "core/cmd/stop_on_signal.h"

#include <atomic>
#include <chrono>

namespace qray::cmd {
namespace {

// A handler may only touch a lock-free atomic, and has nowhere else to find it.
std::atomic<bool> signaled{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int) { signaled.store(true); }

}  // namespace

StopOnSignal::StopOnSignal() {
  signaled.store(false);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
  watcher_ = std::jthread([this](std::stop_token ended) {
    while (!ended.stop_requested() && !signaled.load())
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (signaled.load()) source_.request_stop();
  });
}

StopOnSignal::~StopOnSignal() {
  watcher_.request_stop();
  watcher_.join();
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

}  // namespace qray::cmd
