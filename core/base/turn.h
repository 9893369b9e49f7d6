// Lets few in at a time, and gives up rather than pile up threads. Any thread.
#pragma once

#include <chrono>
#include <semaphore>

namespace qray {

class Turn {
 public:
  explicit Turn(std::counting_semaphore<>& semaphore,
                std::chrono::milliseconds patience = std::chrono::seconds(10))
      : semaphore_(semaphore), mine_(semaphore.try_acquire_for(patience)) {}
  ~Turn() {
    if (mine_) semaphore_.release();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  bool mine() const { return mine_; }

 private:
  std::counting_semaphore<>& semaphore_;
  bool mine_;
};

}  // namespace qray
