#include "server/http/socket_stream.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr size_t kMaxLingerBytes = 8u << 20;

void describe(const sockaddr_storage& address, socklen_t size, std::string& ip, int& port) {
  char host[NI_MAXHOST], service[NI_MAXSERV];
  if (getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host, sizeof host, service,
                  sizeof service, NI_NUMERICHOST | NI_NUMERICSERV) == 0) {
    ip = host;
    port = std::atoi(service);
  }
}

// "HTTP/1.1 404 Not Found": 404.
int status_of(std::string_view line) {
  constexpr std::string_view kVersion = "HTTP/1.1 ";
  int status = 0;
  if (line.starts_with(kVersion) && line.size() >= kVersion.size() + 3)
    std::from_chars(line.data() + kVersion.size(), line.data() + kVersion.size() + 3, status);
  return status;
}

}  // namespace

bool SocketStream::wait(short events, Time deadline) const {
  pollfd p{fd_, events, 0};
  if (::poll(&p, 1, 0) > 0) return true;
  if (!on_stall_) return wait_for_client(events, deadline);
  on_stall_(true);
  const bool ready = wait_for_client(events, deadline);
  on_stall_(false);
  return ready;
}

bool SocketStream::wait_for_client(short events, Time deadline) const {
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
    if (left.count() < 0) return false;
    pollfd p{fd_, events, 0};
    const int ready = ::poll(&p, 1, static_cast<int>(left.count()) + 1);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

ssize_t SocketStream::receive(Time deadline) {
  if (!wait(POLLIN, deadline)) return -1;
  char block[16 * 1024];
  ssize_t got;
  do {
    got = ::recv(fd_, block, sizeof block, 0);
  } while (got < 0 && errno == EINTR);
  if (got > 0) {
    raw_.append(block, static_cast<size_t>(got));
    received_bytes_ += static_cast<uint64_t>(got);
  }
  return got;
}

SocketStream::HeadRead SocketStream::read_head(size_t max_bytes, std::string& head) {
  answer_status_ = 0;
  received_bytes_ = raw_.size();
  sent_bytes_ = 0;
  // An empty line before a request is allowed (RFC 9112, section 2.2).
  const auto skip_empty_lines = [&] {
    while (raw_.starts_with("\r\n")) raw_.erase(0, 2);
  };
  skip_empty_lines();
  Time deadline = steady_clock::now() + (raw_.empty() ? limits_.idle : limits_.head);
  bool begun = !raw_.empty();
  size_t searched = 0;
  for (;;) {
    const size_t end = raw_.find("\r\n\r\n", searched);
    if (end != std::string::npos && end + 4 <= max_bytes) {
      head = raw_.substr(0, end + 4);
      raw_.erase(0, end + 4);
      return HeadRead::kOk;
    }
    if (raw_.size() >= max_bytes) return HeadRead::kTooLarge;
    searched = raw_.size() < 3 ? 0 : raw_.size() - 3;
    const ssize_t got = receive(deadline);
    if (got == 0) return HeadRead::kClosed;
    if (got < 0) return begun ? HeadRead::kTimeout : HeadRead::kClosed;
    if (!begun) {
      begun = true;
      deadline = steady_clock::now() + limits_.head;
      skip_empty_lines();
      searched = 0;
    }
  }
}

SocketStream::Time SocketStream::read_deadline() const {
  return std::min(body_deadline_, steady_clock::now() + limits_.body);
}

void SocketStream::begin(std::string head, size_t body_bytes) {
  front_ = std::move(head);
  front_at_ = 0;
  body_left_ = body_bytes;
  begun_ = steady_clock::now();
  body_deadline_ = begun_ + limits_.body + milliseconds(body_bytes / 100);
}

bool SocketStream::skip_rest() {
  char block[4096];
  while (body_left_ > 0) {
    if (read(block, sizeof block) <= 0) return false;
  }
  return true;
}

void SocketStream::linger(milliseconds time) {
  ::shutdown(fd_, SHUT_WR);
  const Time deadline = steady_clock::now() + time;
  size_t taken = 0;
  do {
    taken += raw_.size();
    raw_.clear();
  } while (taken < kMaxLingerBytes && receive(deadline) > 0);
}

bool SocketStream::is_readable() const {
  return front_at_ < front_.size() ||
         (body_left_ > 0 && (!raw_.empty() || wait(POLLIN, read_deadline())));
}

// Also how an open event stream learns that its reader has gone. A client may shut its sending side
// after a request and still wait for the answer, so that alone counts only after a second.
bool SocketStream::is_writable() const {
  pollfd p{fd_, POLLOUT | POLLRDHUP, 0};
  int ready;
  do {
    ready = ::poll(&p, 1, static_cast<int>(limits_.write_stall.count()));
  } while (ready < 0 && errno == EINTR);
  if (ready <= 0 || (p.revents & (POLLHUP | POLLERR | POLLNVAL))) return false;
  const bool half_closed = p.revents & POLLRDHUP;
  if (half_closed && steady_clock::now() - begun_ > std::chrono::seconds(1)) return false;
  return (p.revents & POLLOUT) || wait(POLLOUT, steady_clock::now() + limits_.write_stall);
}

ssize_t SocketStream::read(char* out, size_t size) {
  if (front_at_ < front_.size()) {
    const size_t take = std::min(size, front_.size() - front_at_);
    std::memcpy(out, front_.data() + front_at_, take);
    front_at_ += take;
    return static_cast<ssize_t>(take);
  }
  if (body_left_ == 0) return 0;
  if (raw_.empty() && receive(read_deadline()) <= 0) return -1;
  const size_t take = std::min({size, raw_.size(), body_left_});
  std::memcpy(out, raw_.data(), take);
  raw_.erase(0, take);
  body_left_ -= take;
  return static_cast<ssize_t>(take);
}

ssize_t SocketStream::write(const char* data, size_t size) {
  if (answer_status_ == 0) answer_status_ = status_of({data, size});
  const Time deadline = steady_clock::now() + limits_.write_stall + milliseconds(size / 100);
  size_t sent = 0;
  while (sent < size) {
    const Time stall = steady_clock::now() + limits_.write_stall;
    if (!wait(POLLOUT, std::min(deadline, stall))) return -1;
    const ssize_t n = ::send(fd_, data + sent, size - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) {
      sent += static_cast<size_t>(n);
      sent_bytes_ += static_cast<uint64_t>(n);
    }
    if (n < 0 && errno != EINTR && errno != EAGAIN) return -1;
  }
  return static_cast<ssize_t>(size);
}

void SocketStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getpeername(fd_, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    describe(address, size, ip, port);
  }
}

void SocketStream::get_local_ip_and_port(std::string& ip, int& port) const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    describe(address, size, ip, port);
  }
}

}  // namespace qray::server
