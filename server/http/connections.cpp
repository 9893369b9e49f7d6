#include "server/http/connections.h"

#include <sys/socket.h>
#include <unistd.h>

#include <system_error>
#include <thread>

namespace qray::server {

using std::chrono::steady_clock;

bool Connections::start(int fd, std::function<void(uint64_t)> body) {
  uint64_t id;
  {
    std::unique_lock lock(mutex_);
    const auto room = [&] { return open_.size() < max_ || stopping_; };
    for (int i = 0; i < 20 && !room(); ++i) {
      evict_one();
      ended_.wait_for(lock, std::chrono::milliseconds(50), room);
    }
    if (open_.size() >= max_ || stopping_) {
      ::close(fd);
      return false;
    }
    id = next_id_++;
    open_[id] = {.fd = fd, .since = steady_clock::now()};
  }
  const auto end = [this, id, fd] {
    std::lock_guard lock(mutex_);
    open_.erase(id);  // before the number fd can belong to another connection
    ::close(fd);
    ended_.notify_all();
  };
  try {
    std::thread([body = std::move(body), id, end] {
      body(id);
      end();
    }).detach();  // stop() waits until it has left open_
  } catch (const std::system_error&) {
    end();
    return false;
  }
  return true;
}

void Connections::set_idle(uint64_t id, bool idle) {
  std::lock_guard lock(mutex_);
  Entry& entry = open_.at(id);
  entry.idle = idle;
  entry.since = steady_clock::now();
}

void Connections::set_stalled(uint64_t id, bool stalled) {
  std::lock_guard lock(mutex_);
  open_.at(id).stalled = stalled;
}

void Connections::evict_one() {
  Entry* chosen = nullptr;
  for (auto& [id, entry] : open_) {
    if (entry.evicted || !(entry.idle || entry.stalled)) continue;
    const bool better =
        !chosen || (entry.idle != chosen->idle ? entry.idle : entry.since < chosen->since);
    if (better) chosen = &entry;
  }
  if (!chosen) return;
  ::shutdown(chosen->fd, SHUT_RDWR);
  chosen->evicted = true;
}

void Connections::stop() {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  for (auto& [id, entry] : open_) ::shutdown(entry.fd, SHUT_RDWR);
  ended_.notify_all();
  ended_.wait(lock, [&] { return open_.empty(); });
}

bool Connections::stopping() const {
  std::lock_guard lock(mutex_);
  return stopping_;
}

size_t Connections::count() const {
  std::lock_guard lock(mutex_);
  return open_.size();
}

}  // namespace qray::server
