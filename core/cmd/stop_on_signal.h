// Turns the first Ctrl-C (SIGINT) or SIGTERM into a request to stop; the second one ends the
// program as usual. One at a time in a process; its token may be read by any thread.
#pragma once

#include <signal.h>

#include <stop_token>
#include <thread>

namespace qray::cmd {

class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();  // gives the signals back
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  struct sigaction old_interrupt_ {
  }, old_terminate_{};
  std::jthread watcher_;
};

}  // namespace qray::cmd
