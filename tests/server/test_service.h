// A real Service on a scratch folder and port 0, a client, and raw connections, for tests.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/base/sha256.h"
#include "server/service.h"
#include "tests/server/box_scene.h"
#include "tests/support/contract.h"
#include "tests/support/places.h"
#include "tests/support/scratch.h"

namespace qray::server::test {

using Json = nlohmann::json;

inline std::string sha(const std::string& text) {
  return sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()}).hex();
}

inline Config scratch_config(const std::filesystem::path& folder) {
  write_text(folder / "scenes/box/scene.json", kBoxScene);
  write_text(folder / "web/index.html", "<!doctype html><title>page</title>");
  Config config;
  config.port = 0;
  config.data = folder / "data";
  config.scenes = folder / "scenes";
  config.web = folder / "web";
  config.openapi = qray::test::source_dir() / "proto/openapi.yaml";
  config.threads = 2;
  config.jobs_at_once = 1;  // one after another, as most tests expect
  return config;
}

inline HttpLimits quick_limits() {
  HttpLimits limits;
  limits.stream.head = std::chrono::milliseconds(500);
  limits.stream.body = std::chrono::milliseconds(1000);
  return limits;
}

class TestService {
 public:
  TestService() : config(scratch_config(scratch.path())) {}

  void start() {
    Result<std::unique_ptr<Service>> started = Service::start(config);
    ASSERT_TRUE(started.ok()) << started.error().text();
    service = std::move(started).value();
  }
  void stop() { service.reset(); }

  httplib::Client client() const {
    httplib::Client c("127.0.0.1", service->port());
    c.set_read_timeout(20);
    // Whatever is asked: its answer must be one that the contract lists.
    c.set_logger([](const httplib::Request& req, const httplib::Response& res) {
      EXPECT_EQ(
          qray::test::Contract::instance().fault(
              {req.method, req.path, res.status, res.get_header_value("Content-Type"), res.body}),
          "");
    });
    return c;
  }
  // The answer's JSON; its status must be `status`.
  Json get(const std::string& path, int status = 200) const {
    return answer(client().Get(path), path, status);
  }
  Json post(const std::string& path, const std::string& body, int status) const {
    return answer(client().Post(path, body, "application/json"), path + " " + body, status);
  }
  std::string submit(const Json& request) const {
    return post("/v1/jobs", request.dump(), 202).value("id", "");
  }
  // Waits until the job is in one of the states, and returns it.
  Json wait(const std::string& id, const std::vector<std::string>& states) const {
    for (int i = 0; i < 4000; ++i) {
      Json job = get("/v1/jobs/" + id);
      for (const std::string& state : states) {
        if (job["state"] == state) return job;
      }
      if (job["state"] == "failed") {
        ADD_FAILURE() << job.dump();
        return job;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << id << " does not become " << states[0];
    return {};
  }
  Json wait_end(const std::string& id) const {
    return wait(id, {"succeeded", "canceled", "failed"});
  }

  qray::test::ScratchFolder scratch;
  Config config;
  std::unique_ptr<Service> service;

 private:
  static Json answer(const httplib::Result& result, const std::string& what, int status) {
    if (!result) {
      ADD_FAILURE() << what << ": no answer: " << httplib::to_string(result.error());
      return {};
    }
    EXPECT_EQ(result->status, status) << what << ": " << result->body;
    Json json = Json::parse(result->body, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << what << ": " << result->body;
    return json;
  }
};

// A connection without a client's manners.
class RawConnection {
 public:
  // `held_bytes`: of the answer, that the system holds for it; 0: as much as it likes.
  explicit RawConnection(int port, int held_bytes = 0) : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (held_bytes > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &held_bytes, sizeof held_bytes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    timeval timeout{15, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
  }
  ~RawConnection() { ::close(fd_); }
  RawConnection(RawConnection&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)), rest_(std::move(other.rest_)) {}

  // False when the other side does not take it any more.
  bool send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t n = ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      text.remove_prefix(static_cast<size_t>(n));
    }
    return true;
  }
  // Up to and with `end`, or until the connection is over; what came after it is for the next call.
  std::string read_until(std::string_view end) {
    char block[4096];
    size_t at;
    while ((at = end.empty() ? std::string::npos : rest_.find(end)) == std::string::npos) {
      const ssize_t n = ::recv(fd_, block, sizeof block, 0);
      if (n <= 0) return std::exchange(rest_, "");
      rest_.append(block, static_cast<size_t>(n));
    }
    std::string text = rest_.substr(0, at + end.size());
    rest_.erase(0, text.size());
    return text;
  }
  // Up to `size` bytes, at least one; empty: the connection is over.
  std::string read_some(size_t size) {
    std::string block(size, '\0');
    if (rest_.empty()) {
      const ssize_t n = ::recv(fd_, block.data(), size, 0);
      block.resize(n > 0 ? static_cast<size_t>(n) : 0);
      return block;
    }
    block = rest_.substr(0, size);
    rest_.erase(0, block.size());
    return block;
  }
  std::string read_all() { return read_until(""); }

 private:
  int fd_;
  std::string rest_;
};

}  // namespace qray::server::test
