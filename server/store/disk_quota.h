// Bytes that uploads may take on disk, all together. Any thread.
#pragma once

#include <cstdint>
#include <mutex>

namespace qray::server {

class DiskQuota {
 public:
  explicit DiskQuota(uint64_t bytes) : bytes_(bytes) {}

  // What a file of this size takes: whole blocks, and at least one, so that a flood of empty files
  // ends too.
  static constexpr uint64_t on_disk(uint64_t bytes) {
    constexpr uint64_t kBlock = 4096;
    return (bytes / kBlock + 1) * kBlock;
  }

  bool take(uint64_t bytes) {
    std::lock_guard lock(mutex_);
    if (bytes > bytes_ || used_ > bytes_ - bytes) return false;
    used_ += bytes;
    return true;
  }
  // What is there already, even when it is too much.
  void note(uint64_t bytes) {
    std::lock_guard lock(mutex_);
    used_ += bytes;
  }
  void give_back(uint64_t bytes) {
    std::lock_guard lock(mutex_);
    used_ -= bytes;
  }
  uint64_t bytes() const { return bytes_; }
  uint64_t used() const {
    std::lock_guard lock(mutex_);
    return used_;
  }

 private:
  const uint64_t bytes_;
  mutable std::mutex mutex_;
  uint64_t used_ = 0;
};

}  // namespace qray::server
