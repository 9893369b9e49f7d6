// A pause that ends early when a stop is asked for.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>

namespace qray::server {

// Until what the disk did not take is tried again.
constexpr std::chrono::seconds kDiskAgain{1};

// False: a stop was asked for.
inline bool wait_unless(const std::stop_token& stop, std::chrono::milliseconds time) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace qray::server
