// `qray submit` of files here, against a server that plays the part docs/api.md gives it.
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/sha256.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string sha(const std::string& text) {
  return sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()}).hex();
}

class UploadServer {
 public:
  UploadServer() {
    port_ = http_.bind_to_any_port("127.0.0.1");
    const std::string asset = "/v1/assets/([0-9a-f]{64})";
    http_.Get(asset, [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      res.status = assets_.contains(req.matches[1]) ? 200 : 404;
    });
    http_.Put(asset, [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      ++puts_;
      res.status = put_status_;
      if (put_status_ == 201)
        assets_[req.matches[1]] = req.body;
      else
        res.set_content(R"({"title":"Insufficient storage","detail":"no room"})",
                        "application/problem+json");
    });
    http_.Post("/v1/scenes", [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      scene_ = json::parse(req.body);
      res.status = 201;
      res.set_content(R"({"name":"up-1","warnings":["a.obj: has no light"]})", "application/json");
    });
    http_.Post("/v1/jobs", [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      job_ = json::parse(req.body);
      res.status = 202;
      res.set_content(R"({"id":"j1","state":"queued"})", "application/json");
    });
    thread_ = std::thread([this] { http_.listen_after_bind(); });
    while (!http_.is_running()) std::this_thread::yield();
  }
  ~UploadServer() {
    http_.stop();
    thread_.join();
  }
  Outcome submit(const fs::path& scene) const {
    return qray_command(
        {"submit", scene, "--spp", "4", "--server", "http://127.0.0.1:" + std::to_string(port_)});
  }

  int put_status_ = 201, puts_ = 0;  // looked at between commands
  std::map<std::string, std::string> assets_;
  json scene_, job_;

 private:
  httplib::Server http_;
  int port_ = 0;
  std::thread thread_;
  std::mutex mutex_;
};

class Upload : public ::testing::Test {
 protected:
  void write(const char* name, const std::string& text) {
    fs::create_directories((scratch_ / name).parent_path());
    std::ofstream(scratch_ / name, std::ios::binary) << text;
  }
  UploadServer server_;
  ScratchFolder scratch_;
};

TEST_F(Upload, AFileGoesWithItsFolderAndOnlyWhatIsMissingIsSent) {
  const std::string large(3 << 20, 'x');
  write("room/a.obj", "v 0 0 0");
  write("room/textures/t.png", large);
  write("room/empty", "");
  const Outcome done = server_.submit(scratch_ / "room/a.obj");
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(done.out, "j1\n");
  EXPECT_NE(done.err.find("warning: a.obj: has no light"), std::string::npos) << done.err;
  EXPECT_EQ(
      server_.scene_,
      (json{{"entry", "a.obj"},
            {"files",
             {{"a.obj", sha("v 0 0 0")}, {"textures/t.png", sha(large)}, {"empty", sha("")}}}}));
  EXPECT_EQ(server_.assets_.at(sha(large)), large);
  EXPECT_EQ(server_.job_, (json{{"scene", "up-1"}, {"samples", 4}}));
  EXPECT_EQ(server_.puts_, 3);
  EXPECT_EQ(server_.submit(scratch_ / "room").code, cmd::kExitOk);
  EXPECT_FALSE(server_.scene_.contains("entry")) << "of a folder, the server looks for it";
  EXPECT_EQ(server_.puts_, 3) << "all were there";
}

TEST_F(Upload, GlbAndZipGoAlone) {
  write("beside.txt", "x");
  for (const char* type : {"glb", "zip"}) {
    const std::string name = std::string("a.") + type;
    write(name.c_str(), name);
    EXPECT_EQ(server_.submit(scratch_ / name).code, cmd::kExitOk);
    EXPECT_EQ(server_.scene_, (json{{"asset", sha(name)}, {"type", type}}));
  }
  EXPECT_EQ(server_.assets_.size(), 2u);
}

TEST_F(Upload, TellsWhatTheServerRefuses) {
  write("a.glb", "glTF");
  server_.put_status_ = 507;
  const Outcome full = server_.submit(scratch_ / "a.glb");
  EXPECT_NE(full.code, cmd::kExitOk);
  EXPECT_NE(full.err.find("507"), std::string::npos) << full.err;
  EXPECT_NE(full.err.find("no room"), std::string::npos) << full.err;
  EXPECT_TRUE(server_.job_.is_null());
}

// Knows no asset, and hangs up when one comes.
class RudeServer {
 public:
  RudeServer() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 8), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int client; (client = accept(listener_, nullptr, nullptr)) >= 0; close(client)) {
        char head[4096];
        const ssize_t got = recv(client, head, sizeof head, 0);
        if (got < 4 || std::string_view(head, 4) != "HEAD") continue;
        constexpr std::string_view kNone = "HTTP/1.1 404 Not Found\r\nConnection: close\r\n\r\n";
        (void)send(client, kNone.data(), kNone.size(), MSG_NOSIGNAL);
      }
    });
  }
  ~RudeServer() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }
  int port = 0;

 private:
  int listener_ = -1;
  std::thread thread_;
};

TEST_F(Upload, AServerThatHangsUpIsAnError) {
  const RudeServer rude;
  write("a.glb", "");
  fs::resize_file(scratch_ / "a.glb", size_t{64} << 20);  // more than a socket holds
  const Outcome refused = qray_command(
      {"submit", scratch_ / "a.glb", "--server", "http://127.0.0.1:" + std::to_string(rude.port)});
  EXPECT_NE(refused.code, cmd::kExitOk);
  EXPECT_NE(refused.err.find("a.glb: the server hung up"), std::string::npos) << refused.err;
}

TEST_F(Upload, TooMuchIsRefusedBeforeAnythingIsSent) {
  write("many/scene.json", "{}");
  for (int i = 0; i < 4096; ++i) write(("many/" + std::to_string(i)).c_str(), "");
  write("big/scene.json", "{}");
  write("big/data", "");
  fs::resize_file(scratch_ / "big/data", size_t{1} << 30);  // a file of holes
  for (const char* folder : {"many", "big"}) {
    const Outcome refused = server_.submit(scratch_ / folder / "scene.json");
    EXPECT_EQ(refused.code, cmd::kExitBadInput);
    EXPECT_NE(refused.err.find("4096 files and 1 GiB"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(server_.puts_, 0);
}

}  // namespace
}  // namespace qray::test
