#include "server/webhooks/post.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace qray::server {
namespace {

using std::chrono::steady_clock;

constexpr size_t kStatusBytes = 12;  // "HTTP/1.1 200"

Error refused(const std::string& what, const WebhookUrl& url) {
  return {ErrorCode::kIo, what, url.host};
}

std::string tls_fault() {
  char text[256] = "TLS failed";
  if (const unsigned long error = ::ERR_get_error()) ::ERR_error_string_n(error, text, sizeof text);
  ::ERR_clear_error();
  return text;
}

// One for the process: reading the system's certificates takes a while. Null: that failed.
SSL_CTX* tls_context() {
  static SSL_CTX* const context = [] {
    SSL_CTX* made = ::SSL_CTX_new(::TLS_client_method());
    if (!made) return made;
    ::SSL_CTX_set_min_proto_version(made, TLS1_2_VERSION);
    ::SSL_CTX_set_default_verify_paths(made);
    ::SSL_CTX_set_verify(made, SSL_VERIFY_PEER, nullptr);
    return made;
  }();
  return context;
}

class Line {
 public:
  Line(const WebhookUrl& url, steady_clock::time_point deadline, const std::stop_token& stop)
      : url_(url), deadline_(deadline), stop_(stop) {}
  ~Line() {
    tls_.reset();
    if (fd_ >= 0) ::close(fd_);
  }

  Status connect(const Address& address) {
    fd_ = ::socket(address.any.sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd_ < 0) return refused(std::strerror(errno), url_);
    if (::connect(fd_, &address.any, address.size()) != 0 && errno != EINPROGRESS)
      return refused(std::strerror(errno), url_);
    if (Status s = wait(POLLOUT); !s.ok()) return s;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return refused(std::strerror(error), url_);
    return url_.tls ? shake_hands() : Status();
  }

  Status send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = tls_ ? ::SSL_write(tls_.get(), bytes.data(), static_cast<int>(bytes.size()))
                             : ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n > 0) {
        bytes.remove_prefix(static_cast<size_t>(n));
      } else if (Status s = wait_after(n, POLLOUT); !s.ok()) {
        return s;
      }
    }
    return {};
  }

  Result<int> read_status() {
    char text[kStatusBytes];
    for (size_t have = 0; have < kStatusBytes;) {
      const size_t room = kStatusBytes - have;
      const ssize_t n = tls_ ? ::SSL_read(tls_.get(), text + have, static_cast<int>(room))
                             : ::recv(fd_, text + have, room, 0);
      if (n > 0) {
        have += static_cast<size_t>(n);
      } else if (Status s = n == 0 && !tls_ ? refused("no answer", url_) : wait_after(n, POLLIN);
                 !s.ok()) {
        return s.error();
      }
    }
    const std::string_view line(text, kStatusBytes);
    const std::string_view code = line.substr(9);
    if (!line.starts_with("HTTP/1.") ||
        code.find_first_not_of("0123456789") != std::string_view::npos)
      return refused("expected an answer in HTTP/1", url_);
    return (code[0] - '0') * 100 + (code[1] - '0') * 10 + (code[2] - '0');
  }

 private:
  Status shake_hands() {
    if (!tls_context()) return refused(tls_fault(), url_);
    tls_.reset(::SSL_new(tls_context()));
    if (!tls_ || ::SSL_set_fd(tls_.get(), fd_) != 1 || !expect_certificate())
      return refused(tls_fault(), url_);
    for (int done; (done = ::SSL_connect(tls_.get())) != 1;) {
      const Status waited = wait_after(done, POLLIN);
      const long judged = ::SSL_get_verify_result(tls_.get());
      if (judged != X509_V_OK)
        return refused(std::string("its certificate: ") + ::X509_verify_cert_error_string(judged),
                       url_);
      if (!waited.ok()) return waited;
    }
    return {};
  }

  // The certificate must name the host: an address as such, which is not asked for by name.
  bool expect_certificate() {
    const char* host = url_.host.c_str();
    if (::X509_VERIFY_PARAM_set1_ip_asc(::SSL_get0_param(tls_.get()), host) == 1) return true;
    return ::SSL_set1_host(tls_.get(), host) == 1 &&
           ::SSL_set_tlsext_host_name(tls_.get(), host) == 1;
  }

  // After a call that did not go on: until it may.
  Status wait_after(ssize_t result, short events) {
    if (!tls_) {
      const bool later = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
      return later ? wait(events) : refused(std::strerror(errno), url_);
    }
    switch (::SSL_get_error(tls_.get(), static_cast<int>(result))) {
      case SSL_ERROR_WANT_READ:
        return wait(POLLIN);
      case SSL_ERROR_WANT_WRITE:
        return wait(POLLOUT);
      default:
        return refused(tls_fault(), url_);
    }
  }

  Status wait(short events) {
    constexpr int kLookMs = 50;
    for (;;) {
      if (stop_.stop_requested()) return refused("the server stops", url_);
      if (steady_clock::now() > deadline_) return refused("no answer in time", url_);
      pollfd p{fd_, events, 0};
      if (::poll(&p, 1, kLookMs) > 0) return {};
    }
  }

  struct FreeTls {
    void operator()(SSL* tls) const { ::SSL_free(tls); }
  };
  const WebhookUrl& url_;
  const steady_clock::time_point deadline_;
  const std::stop_token& stop_;
  int fd_ = -1;
  std::unique_ptr<SSL, FreeTls> tls_;
};

}  // namespace

Result<int> post(const WebhookUrl& url, const Address& address, std::string_view request,
                 steady_clock::time_point deadline, const std::stop_token& stop) {
  Line line(url, deadline, stop);
  if (Status s = line.connect(address); !s.ok()) return s.error();
  if (Status s = line.send(request); !s.ok()) return s.error();
  return line.read_status();
}

}  // namespace qray::server
