// The qrayd program itself: what it prints, how it ends, and what a sudden end leaves.
#include "tests/server/process.h"
#include "tests/support/sanitized.h"

namespace qray::server {
namespace {

using test::Json;

using test::Process;

class ProcessTest : public ::testing::Test {
 protected:
  qray::test::ScratchFolder scratch_;
  Config config_ = test::scratch_config(scratch_.path());
  Json job(int samples) const {
    return {{"scene", "box"},     {"method", "huang"},      {"width", 32}, {"height", 32},
            {"samples", samples}, {"learning_samples", 16}, {"seed", 4}};
  }
};

TEST_F(ProcessTest, SaysWhereItListensAndEndsOrderly) {
  Process server(config_);
  EXPECT_EQ(server.printed(),
            "qrayd listening on http://127.0.0.1:" + std::to_string(server.port()) + "\n");
  EXPECT_EQ(server.get("/healthz")["status"], "ok");
  const std::string id = server.submit(job(1'000'000));
  server.wait_state(id, "rendering");
  test::RawConnection stream(server.port());
  stream.send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  stream.read_until(": qray");
  const auto begin = std::chrono::steady_clock::now();
  const int status = server.end(SIGTERM);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(ProcessTest, ASignalMakesItReadTheTokensAgain) {
  const auto line = [](const std::string& token) { return "a read " + sha256(token).hex() + "\n"; };
  config_.tokens = scratch_ / "tokens";
  test::write_text(config_.tokens, line("first"));
  Process server(config_);
  const auto status = [&](const std::string& token) {
    return httplib::Client("127.0.0.1", server.port())
        .Get("/v1/jobs", {{"Authorization", "Bearer " + token}})
        ->status;
  };
  EXPECT_EQ(status("first"), 200);
  test::write_text(config_.tokens, line("second"));
  server.send(SIGHUP);
  for (int i = 0; i < 2000 && status("second") != 200; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(status("second"), 200);
  EXPECT_EQ(status("first"), 401);
}

TEST_F(ProcessTest, AKilledServersJobsRunAgainWithTheSameBits) {
  const int samples = qray::test::kSanitized ? 300 : 800;  // takes longer than a look at its state
  const auto tiles = [](const Process& server, const std::string& id) {
    return httplib::Client("127.0.0.1", server.port()).Get("/v1/jobs/" + id + "/tiles")->body;
  };
  std::string id, queued;
  {
    Process server(config_);
    id = server.submit(job(samples));
    queued = server.submit(job(samples));
    server.wait_state(id, "rendering");
    const int status = server.end(SIGKILL);
    EXPECT_TRUE(WIFSIGNALED(status));
  }
  Process server(config_);
  server.wait_state(id, "succeeded");
  const Json second = server.wait_state(queued, "succeeded");
  EXPECT_TRUE(second["table_in"].is_string());
  const std::string again = server.submit([&] {
    Json request = job(samples);
    request["table"] = "none";
    return request;
  }());
  server.wait_state(again, "succeeded");
  EXPECT_TRUE(tiles(server, id) == tiles(server, again));
  EXPECT_FALSE(tiles(server, queued) == tiles(server, again));  // it started from a table
}

TEST_F(ProcessTest, AFileThatMustNotGrowIsAnErrorAndNoEnd) {
  Process server(config_, "-f 4000");  // blocks of 512 or 1024 bytes
  Json large = job(1);
  large["width"] = large["height"] = 1024;
  large["method"] = "none";
  const std::string id = server.submit(large);
  const Json ended = server.wait_state(id, "failed");
  EXPECT_NE(ended["error"]["message"].get<std::string>().find("File too large"), std::string::npos)
      << ended.dump();
  EXPECT_EQ(server.get("/healthz")["status"], "ok");
}

TEST_F(ProcessTest, FewFileDescriptorsMeanFewConnections) {
  Process server(config_, "-n 100");
  std::vector<test::RawConnection> silent;
  for (int i = 0; i < 60; ++i) silent.emplace_back(server.port());
  EXPECT_EQ(server.get("/healthz")["status"], "ok");
  server.wait_state(server.submit(job(1)), "succeeded");
}

TEST_F(ProcessTest, ALargeJobDoesNotHoldUpTheEnd) {
  Process server(config_);
  Json large = job(1'000'000);
  large["width"] = large["height"] = 4096;
  const std::string id = server.submit(large);
  server.wait_state(id, "learning");
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // its first state is being written
  const auto begin = std::chrono::steady_clock::now();
  const int status = server.end(SIGTERM);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(ProcessTest, ASecondServerOnTheFolderExitsWithAnError) {
  Process first(config_);
  Process second(config_);
  EXPECT_EQ(second.printed(), "");
  const int status = second.wait();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << status;
  EXPECT_EQ(first.get("/healthz")["status"], "ok");
}

}  // namespace
}  // namespace qray::server
