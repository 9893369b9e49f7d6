#include "tests/support/bad_line.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <optional>

namespace qray::test {
namespace {

using std::chrono::milliseconds;
constexpr int kLookMs = 50;  // how soon a thread sees that all is over

int socket_of(const std::filesystem::path& path, decltype(&::connect) attach) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw std::runtime_error(path.string() + " is too long for a socket");
  path.string().copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (attach(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

bool send_all(int to, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t sent = ::send(to, data, size, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    data += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

}  // namespace

BadLine::BadLine(std::filesystem::path server)
    : server_(std::move(server)), listener_(socket_of(scratch_ / server_.filename(), &::bind)) {
  if (listener_ < 0 || ::listen(listener_, 64) != 0)
    throw std::runtime_error("cannot listen in " + scratch_.path().string());
  acceptor_ = std::thread([this] { accept(); });
}

BadLine::~BadLine() {
  over_ = true;
  acceptor_.join();
  for (std::thread& carrier : carriers_) carrier.join();
  ::close(listener_);
}

void BadLine::go_bad(uint64_t seed) {
  std::lock_guard lock(mutex_);
  random_.seed(seed);
  bad_ = true;
}

std::map<std::string, int> BadLine::ends() const {
  std::lock_guard lock(mutex_);
  return ends_;
}

// Half of all connections are quick; one end in thirty is silence, as it costs the most time.
BadLine::Fate BadLine::draw() {
  std::lock_guard lock(mutex_);
  const size_t bytes = static_cast<size_t>(
      std::exp(std::uniform_real_distribution<>(std::log(300.), std::log(300e3))(random_)));
  const uint64_t kind = random_() % 30;
  const End end = kind < 10   ? End::kCut
                  : kind < 19 ? End::kClosedToServer
                  : kind < 29 ? End::kClosedToClient
                              : End::kSilent;
  return {bytes, end, milliseconds(random_() % 2 ? random_() % 60 : 0)};
}

void BadLine::note(End end) {
  constexpr const char* kNames[] = {"cut", "closed to the server", "closed to the client",
                                    "silent"};
  std::lock_guard lock(mutex_);
  ++ends_[kNames[static_cast<int>(end)]];
}

void BadLine::accept() {
  while (!over_) {
    pollfd ready{listener_, POLLIN, 0};
    if (::poll(&ready, 1, kLookMs) <= 0) continue;
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    const int server = socket_of(server_, &::connect);
    if (server < 0) {  // it has ended
      ::close(client);
      continue;
    }
    carriers_.emplace_back([this, client, server] {
      carry(client, server);
      ::close(client);
      ::close(server);
    });
  }
}

void BadLine::carry(int client, int server) {
  const std::array<int, 2> ends = {client, server};  // what one sends, the other gets
  std::array<bool, 2> open = {true, true};           // it may still send
  std::optional<Fate> fate;
  size_t carried = 0;
  bool closed_one_way = false;
  std::array<char, 16384> data;
  while (!over_ && (open[0] || open[1])) {
    std::array<pollfd, 2> ready{};
    for (int i = 0; i < 2; ++i) ready[i] = {open[i] ? ends[i] : -1, POLLIN, 0};
    if (::poll(ready.data(), 2, kLookMs) <= 0) continue;
    for (int i = 0; i < 2; ++i) {
      if (!open[i] || !ready[i].revents) continue;
      const ssize_t got = ::recv(ends[i], data.data(), data.size(), 0);
      if (got <= 0) {
        open[i] = false;
        ::shutdown(ends[1 - i], SHUT_WR);
        continue;
      }
      size_t size = static_cast<size_t>(got);
      if (bad_ && !fate) fate = draw();
      const bool ends_now = bad_ && fate && !closed_one_way && carried + size > fate->bytes;
      if (fate) std::this_thread::sleep_for(fate->delay);
      if (ends_now) size = fate->bytes - carried;
      carried += size;
      if (!send_all(ends[1 - i], data.data(), size)) return;
      if (!ends_now) continue;
      note(fate->end);
      if (fate->end == End::kCut) return;
      if (fate->end == End::kSilent) {  // until either end has gone
        std::array<pollfd, 2> gone{};
        do {
          for (int j = 0; j < 2; ++j) gone[j] = {ends[j], 0, 0};
        } while (!over_ && ::poll(gone.data(), 2, kLookMs) <= 0);
        return;
      }
      // The one end hears no more; what it sends still goes through.
      closed_one_way = true;
      const int deaf = fate->end == End::kClosedToServer ? 1 : 0;
      ::shutdown(ends[deaf], SHUT_WR);
      open[1 - deaf] = false;
    }
  }
}

}  // namespace qray::test
