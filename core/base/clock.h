// Time as an argument: what reads a clock takes one, so a test can turn the hands. Any thread.
#pragma once

#include <chrono>

namespace qray {

class Clock {
 public:
  virtual ~Clock() = default;
  virtual double seconds() const = 0;  // monotonic, from an arbitrary origin
};

class SteadyClock final : public Clock {
 public:
  double seconds() const override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
};

}  // namespace qray
