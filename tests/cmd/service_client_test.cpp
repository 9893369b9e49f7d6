// The client subcommands against a server that plays the part docs/api.md gives it.
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/file.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

class FakeServer {
 public:
  FakeServer() {
    port_ = http_.bind_to_any_port("127.0.0.1");
    http_.Post("/v1/jobs", [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      posted_ = req.body;
      authorization_ = req.get_header_value("Authorization");
      answer_post(res);
    });
    http_.Get("/v1/jobs/j1", [this](const httplib::Request&, httplib::Response& res) {
      res.set_content(job(polls_++ < running_polls_ ? "rendering" : end_state_),
                      "application/json");
    });
    http_.Post("/v1/jobs/j1/cancel", [](const httplib::Request&, httplib::Response& res) {
      res.status = 202;
      res.set_content(R"({"id":"j1","state":"canceling"})", "application/json");
    });
    http_.Post("/v1/jobs/j1/extend", [](const httplib::Request& req, httplib::Response& res) {
      const nlohmann::json job = {{"id", "j1"}, {"state", "queued " + req.body}};
      res.set_content(job.dump(), "application/json");
    });
    http_.Get("/v1/jobs/j1/log", [](const httplib::Request&, httplib::Response& res) {
      res.set_content("then info queued\n", "text/plain");
    });
    http_.Get("/v1/jobs/j1/image.png", [](const httplib::Request& req, httplib::Response& res) {
      res.set_content("PNG at " + req.get_param_value("exposure"), "image/png");
    });
    http_.Get("/v1/jobs/j1/image.exr", [](const httplib::Request&, httplib::Response& res) {
      res.status = 409;
      res.set_content(R"({"title":"Nothing rendered yet"})", "application/problem+json");
    });
    http_.Get("/v1/events", [this](const httplib::Request& req, httplib::Response& res) {
      const std::lock_guard lock(mutex_);
      last_event_id_ = req.get_header_value("Last-Event-ID");
      // Breaks off the first time, before the job has ended.
      res.set_content(streams_++ == 0 ? "id: 4\nevent: progress\ndata: {\"fraction\":0.5}\n\n"
                                      : "id: 5\nevent: done\ndata: {\"state\":\"succeeded\"}\n\n",
                      "text/event-stream");
    });
    thread_ = std::thread([this] { http_.listen_after_bind(); });
    while (!http_.is_running()) std::this_thread::yield();
  }
  ~FakeServer() {
    http_.stop();
    thread_.join();
  }

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }
  std::string posted() {
    const std::lock_guard lock(mutex_);
    return posted_;
  }
  std::string authorization() {
    const std::lock_guard lock(mutex_);
    return authorization_;
  }
  std::string last_event_id() {
    const std::lock_guard lock(mutex_);
    return last_event_id_;
  }

  int post_status_ = 202, running_polls_ = 0;  // set before a command runs
  std::string end_state_ = "succeeded";

 private:
  std::string job(const std::string& state) const {
    const std::string error =
        state == "failed" ? R"({"message":"broken","where":"scene.json:/ior"})" : "null";
    return R"({"id":"j1","state":")" + state + R"(","error":)" + error + "}";
  }
  void answer_post(httplib::Response& res) const {
    res.status = post_status_;
    if (post_status_ == 202) return res.set_content(job("queued"), "application/json");
    res.set_content(R"({"title":"Wrong request","status":422,"errors":[{"pointer":"/samples",)"
                    R"("detail":"expected 1..1000000, got 0"}]})",
                    "application/problem+json");
  }

  httplib::Server http_;
  int port_ = 0;
  std::thread thread_;
  std::mutex mutex_;
  std::string posted_, authorization_, last_event_id_;
  std::atomic<int> polls_{0};
  int streams_ = 0;
};

class ClientCommand : public ::testing::Test {
 protected:
  Outcome client(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", server_.url()});
    return qray_command(arguments);
  }
  FakeServer server_;
};

TEST_F(ClientCommand, SubmitPostsTheOptionsAndPrintsTheId) {
  const Outcome done = client(
      {"submit", "cornell-box", "--spp", "8", "--no-nee", "--size", "64x32", "--table", "none"});
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(done.out, "j1\n");
  EXPECT_EQ(nlohmann::json::parse(server_.posted()),
            nlohmann::json::parse(R"({"scene":"cornell-box","samples":8,"nee":false,"width":64,
                                      "height":32,"table":"none"})"));
}

TEST_F(ClientCommand, SubmitTakesACameraLabelsAndSettingsOfTheGuide) {
  const Outcome done =
      client({"submit", "cornell-box", "--method", "huang:grid=12;alpha=.1", "--camera-position",
              "0,1,-3.5", "--camera-vertical-fov-deg", "30", "--label", "project:lobby", "--label",
              "kind:test", "--priority", "2"});
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(nlohmann::json::parse(server_.posted()),
            nlohmann::json::parse(R"({"scene":"cornell-box","method":"huang",
                "guide":{"alpha":0.1,"grid":12},"priority":2,
                "camera":{"position":[0,1,-3.5],"vertical_fov_deg":30},
                "labels":{"project":"lobby","kind":"test"}})"));
  const Outcome wrong = client({"submit", "cornell-box", "--camera-up", "0,1"});
  EXPECT_EQ(wrong.code, cmd::kExitBadInput);
  EXPECT_NE(wrong.err.find("expected three numbers X,Y,Z, got '0,1'"), std::string::npos)
      << wrong.err;
}

TEST_F(ClientCommand, ATokenIsSentWhenThereIsOne) {
  client({"submit", "cornell-box"});
  EXPECT_EQ(server_.authorization(), "");
  client({"submit", "cornell-box", "--token", "abc"});
  EXPECT_EQ(server_.authorization(), "Bearer abc");
  ::setenv("QRAY_TOKEN", "def", 1);
  client({"submit", "cornell-box"});
  ::unsetenv("QRAY_TOKEN");
  EXPECT_EQ(server_.authorization(), "Bearer def");
  EXPECT_EQ(client({"submit", "cornell-box", "--token", "a\r\nb: c"}).code, cmd::kExitBadInput);
}

TEST_F(ClientCommand, SubmitTellsWhatTheServerRefuses) {
  server_.post_status_ = 422;
  const Outcome wrong = client({"submit", "cornell-box", "--spp", "0"});
  EXPECT_EQ(wrong.code, cmd::kExitBadInput);
  EXPECT_NE(wrong.err.find("/samples: expected 1..1000000, got 0"), std::string::npos) << wrong.err;
  server_.post_status_ = 429;
  EXPECT_EQ(client({"submit", "cornell-box"}).code, cmd::kExitNotNow);
}

TEST_F(ClientCommand, WaitTellsTheEndByItsCode) {
  server_.running_polls_ = 1;
  const Outcome done = client({"wait", "j1"});
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(done.out, "j1 succeeded\n");
  server_.end_state_ = "canceled";
  EXPECT_EQ(client({"wait", "j1"}).code, cmd::kExitCanceled);
  server_.end_state_ = "failed";
  const Outcome failed = client({"wait", "j1"});
  EXPECT_EQ(failed.code, cmd::kExitJobFailed);
  EXPECT_NE(failed.err.find("scene.json:/ior: broken"), std::string::npos) << failed.err;
}

TEST_F(ClientCommand, WaitGivesUp) {
  server_.running_polls_ = 1'000'000;
  EXPECT_EQ(client({"wait", "j1", "--timeout", "0.01"}).code, cmd::kExitNotNow);
}

TEST_F(ClientCommand, WatchResumesABrokenStream) {
  server_.running_polls_ = 3;  // before the first stream, and before the second
  const Outcome done = client({"watch", "j1"});
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(done.out, "j1 succeeded\n");
  EXPECT_EQ(server_.last_event_id(), "4");
}

TEST_F(ClientCommand, CancelSaysTheState) {
  const Outcome done = client({"cancel", "j1"});
  EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(done.out, "j1 canceling\n");
}

TEST_F(ClientCommand, ExtendAsksForMoreAndLogPrints) {
  EXPECT_EQ(client({"extend", "j1", "--spp", "64"}).out, "j1 queued {\"samples\":64}\n");
  EXPECT_EQ(client({"extend", "j1", "--noise", "0.5"}).out, "j1 queued {\"noise\":0.5}\n");
  EXPECT_EQ(client({"log", "j1"}).out, "then info queued\n");
}

TEST_F(ClientCommand, FetchWritesThePicture) {
  const ScratchFolder scratch;
  const std::string png = (scratch / "a.png").string(), exr = (scratch / "a.exr").string();
  ASSERT_EQ(client({"fetch", "j1", "--exposure", "1.5", "-o", png}).code, cmd::kExitOk);
  const auto bytes = read_file(png, 1000);
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(std::string(bytes.value().begin(), bytes.value().end()).substr(0, 10), "PNG at 1.5");
  ASSERT_EQ(client({"fetch", "j1", "--exposure", "auto", "-o", png}).code, cmd::kExitOk);
  const auto automatic = read_file(png, 1000);
  EXPECT_EQ(std::string(automatic.value().begin(), automatic.value().end()), "PNG at auto");
  EXPECT_NE(client({"fetch", "j1", "--exposure", "bright", "-o", png}).code, cmd::kExitOk);
  EXPECT_NE(client({"fetch", "j1", "--exposure", "33", "-o", png}).code, cmd::kExitOk);
  const Outcome early = client({"fetch", "j1", "-o", exr});
  EXPECT_EQ(early.code, cmd::kExitBadInput);
  EXPECT_NE(early.err.find("Nothing rendered yet"), std::string::npos) << early.err;
  EXPECT_FALSE(std::filesystem::exists(exr));
}

TEST_F(ClientCommand, RefusesIdsThatAreNone) {
  for (const char* id : {"../tables", "j1?x=1", "j 1"})
    EXPECT_EQ(client({"cancel", id}).code, cmd::kExitBadInput) << id;
  EXPECT_EQ(client({"wait", "j2"}).code, cmd::kExitBadInput);  // 404, not as qrayd answers
}

TEST(ClientWithoutServer, SaysSo) {
  std::string url;
  {
    const FakeServer gone;
    url = gone.url();
  }
  for (const char* verb : {"wait", "watch", "cancel"}) {
    const Outcome told = qray_command({verb, "j1", "--server", url});
    EXPECT_EQ(told.code, cmd::kExitUnreachable) << verb << told.err;
  }
  EXPECT_EQ(qray_command({"submit", "cornell-box", "--server", url}).code, cmd::kExitUnreachable);
  for (const char* wrong : {"localhost", "ftp://127.0.0.1", "http://127.0.0.1:port"})
    EXPECT_EQ(qray_command({"wait", "j1", "--server", wrong}).code, cmd::kExitBadInput) << wrong;
}

}  // namespace
}  // namespace qray::test
