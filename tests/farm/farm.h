// Servers and workers as processes of their own, on one database and one data folder.
#pragma once

#include <deque>
#include <fstream>
#include <sstream>

#include "tests/server/process.h"
#include "tests/support/postgres_server.h"

namespace qray::server::test {

class FarmTest : public ::testing::Test {
 protected:
  void SetUp() override {
    postgres_ = qray::test::PostgresServer::instance();
    if (!postgres_) GTEST_SKIP() << qray::test::PostgresServer::why();
    config_.store = postgres_->url(postgres_->new_schema());
    config_.lease_seconds = 2;
    config_.shared_pass_seconds = 0;
    write_text(scratch_ / "scenes/box/scene.json", kBoxScene);
  }

  // A front that runs no jobs itself.
  std::unique_ptr<Process> front() {
    Config config = config_;
    config.jobs_at_once = 0;
    return std::make_unique<Process>(config, "", false, log("front"));
  }
  std::unique_ptr<Process> worker(const std::string& name = "worker", int threads = 1) {
    return std::make_unique<Process>(config_, "", true, log(name), threads);
  }
  std::string log(const std::string& name) const { return scratch_ / (name + ".log"); }
  std::string log_text(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(log(name)).rdbuf();
    return text.str();
  }

  static Json job(int samples, int seed = 4, const char* method = "adaptive") {
    return {{"scene", "box"},     {"method", method}, {"width", 64}, {"height", 64},
            {"samples", samples}, {"table", "none"},  {"seed", seed}};
  }
  // Under one key until it is answered: then it is one job, however often it had to be asked.
  static std::string submit_surely(const Process& front, const Json& request,
                                   const std::string& key) {
    for (int tries = 0; tries < 600; ++tries) {
      httplib::Client client("127.0.0.1", front.port());
      const auto answer =
          client.Post("/v1/jobs", {{"Idempotency-Key", key}}, request.dump(), "application/json");
      if (answer && answer->status == 202) return Json::parse(answer->body).value("id", "");
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    ADD_FAILURE() << "no answer";
    return "";
  }
  // The job when it has succeeded or failed, however often the front does not know.
  static Json end_of(const Process& front, const std::string& id) {
    Json job;
    for (int i = 0; i < 3000; ++i) {
      const auto answer = httplib::Client("127.0.0.1", front.port()).Get("/v1/jobs/" + id);
      if (answer && answer->status == 200) job = Json::parse(answer->body);
      if (job.is_object() && (job["state"] == "succeeded" || job["state"] == "failed")) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return job;
  }
  // Of the picture of an ended job.
  std::string picture(const std::string& id) const {
    std::ostringstream bytes;
    bytes << std::ifstream(config_.data / "results" / id / "image.exr", std::ios::binary).rdbuf();
    EXPECT_FALSE(bytes.str().empty()) << id;
    return sha(bytes.str());
  }
  // What one server makes of the same job, by itself and without a database.
  std::string picture_alone(const Json& request) {
    Config alone = scratch_config(scratch_.path());
    alone.data = scratch_ / "alone";
    Process server(alone);
    const std::string id = server.submit(request);
    server.wait_state(id, "succeeded");
    std::ostringstream bytes;
    bytes << std::ifstream(alone.data / "results" / id / "image.exr", std::ios::binary).rdbuf();
    server.end(SIGTERM);
    std::filesystem::remove_all(alone.data);
    return sha(bytes.str());
  }

  qray::test::ScratchFolder scratch_;
  Config config_ = scratch_config(scratch_.path());
  qray::test::PostgresServer* postgres_ = nullptr;
};

}  // namespace qray::server::test
