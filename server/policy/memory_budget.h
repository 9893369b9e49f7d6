// The memory that running jobs and live sessions may take together. A job that does not fit beside
// the others waits until it does; one that never would runs alone. Any thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace qray::server {

class MemoryBudget {
 public:
  explicit MemoryBudget(size_t bytes) : free_(static_cast<int64_t>(bytes)) {}

  // A part of the budget, given back at its end.
  class Part {
   public:
    Part() = default;
    Part(MemoryBudget& budget, int64_t bytes) : budget_(&budget), bytes_(bytes) {}
    Part(Part&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_) {}
    Part& operator=(Part&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Part() {
      if (budget_) budget_->give_back(bytes_);
    }

   private:
    MemoryBudget* budget_ = nullptr;
    int64_t bytes_ = 0;
  };
  // Empty when stopped before there was room.
  Part take(size_t bytes, std::stop_token stop) {
    const auto wanted = static_cast<int64_t>(bytes);
    std::unique_lock lock(mutex_);
    if (!freed_.wait(lock, stop, [&] { return users_ == 0 || wanted <= free_; })) return {};
    return part(wanted);
  }
  // nullopt: there is no room now.
  std::optional<Part> take_now(size_t bytes) {
    const auto wanted = static_cast<int64_t>(bytes);
    std::lock_guard lock(mutex_);
    if (users_ > 0 && wanted > free_) return std::nullopt;
    return part(wanted);
  }

 private:
  Part part(int64_t bytes) {
    ++users_;
    free_ -= bytes;
    return {*this, bytes};
  }
  void give_back(int64_t bytes) {
    std::lock_guard lock(mutex_);
    --users_;
    free_ += bytes;
    freed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable_any freed_;
  int64_t free_;  // below 0: one runs alone that is over it
  int users_ = 0;
};

}  // namespace qray::server
