#include "server/connections.h"

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
    if (open_.size() >= max_) evict_oldest_idle();
    ended_.wait_for(lock, std::chrono::seconds(1),
                    [&] { return open_.size() < max_ || stopping_; });
    if (open_.size() >= max_ || stopping_) {
      ::close(fd);
      return false;
    }
    id = next_id_++;
    open_[id] = {fd, true, steady_clock::now()};
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

void Connections::evict_oldest_idle() {
  Entry* oldest = nullptr;
  for (auto& [id, entry] : open_) {
    if (entry.idle && (!oldest || entry.since < oldest->since)) oldest = &entry;
  }
  if (!oldest) return;
  ::shutdown(oldest->fd, SHUT_RDWR);
  oldest->idle = false;
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
