// One connection's bytes, with a deadline and a quota on everything: a client that sends slowly,
// sends too much or does not read loses its connection and holds up nobody else. One thread.
#pragma once

#include <httplib.h>

#include <chrono>
#include <functional>
#include <string>

namespace qray::server {

struct StreamLimits {
  std::chrono::milliseconds idle{15'000};  // between requests
  std::chrono::milliseconds head{5'000};   // from a request's first byte to its empty line
  std::chrono::milliseconds body{30'000};  // per read; the whole has 1 s more for each 100 KB
  std::chrono::milliseconds write_stall{10'000};  // per write, plus 1 s for each 100 KB
};

class SocketStream final : public httplib::Stream {
 public:
  // `on_stall` is told when the client lets a read or a write wait, and when it goes on.
  SocketStream(int fd, const StreamLimits& limits, std::function<void(bool stalled)> on_stall = {})
      : fd_(fd), limits_(limits), on_stall_(std::move(on_stall)) {}

  enum class HeadRead { kOk, kClosed, kTimeout, kTooLarge };
  // Waits for the next request and reads up to its empty line.
  HeadRead read_head(size_t max_bytes, std::string& head);
  // What the parser is to read now: `head` in place of the one received, then `body_bytes` bytes.
  void begin(std::string head, size_t body_bytes);
  // Reads what the parser left of the body. False: the connection cannot go on.
  bool skip_rest();
  // Since read_head() was called last: the answer's status (0: none yet), and bytes on the wire.
  int answer_status() const { return answer_status_; }
  uint64_t received_bytes() const { return received_bytes_; }
  uint64_t sent_bytes() const { return sent_bytes_; }
  // Lets the client read the last answer even when it is still sending.
  void linger(std::chrono::milliseconds time);

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* out, size_t size) override;
  ssize_t write(const char* data, size_t size) override;
  using httplib::Stream::write;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  int socket() const override { return fd_; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  bool wait(short events, Time deadline) const;
  bool wait_for_client(short events, Time deadline) const;
  Time read_deadline() const;      // of the body's next bytes
  ssize_t receive(Time deadline);  // appends to raw_

  int fd_;
  StreamLimits limits_;
  std::function<void(bool)> on_stall_;
  std::string raw_;    // received, not handed out yet
  std::string front_;  // the accepted head
  size_t front_at_ = 0;
  size_t body_left_ = 0;
  Time begun_{};
  Time body_deadline_{};
  int answer_status_ = 0;
  uint64_t received_bytes_ = 0, sent_bytes_ = 0;
};

}  // namespace qray::server
