// Random sudden ends of everything: workers and fronts are killed, workers sleep for longer than
// their leases and wake up, the database ends as if its machine had lost its power. Whatever was
// acknowledged is rendered, once, to the bits of a server alone. QRAY_FARM_ENDS=100 has so many
// ends.
#include <random>
#include <set>

#include "tests/farm/farm.h"

namespace qray::server {
namespace {

using test::FarmTest;
using test::Json;
using test::Process;

class FarmKillsTest : public FarmTest {
 protected:
  static constexpr int kWorkers = 3;

  void end_something(std::mt19937& random) {
    auto& worker = workers_[random() % kWorkers];
    switch (random() % 8) {
      case 0:
        front_->end(SIGKILL);
        front_ = front();
        return say("front killed");
      case 1:
        postgres_->stop_at_once();
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 3000));
        postgres_->start();
        return say("database ended");
      case 2:
      case 3:
      case 4: {
        worker->send(SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds(2500 + random() % 1500));
        worker->send(SIGCONT);
        return say("worker slept");
      }
      default:
        worker->end(SIGKILL);
        worker = this->worker("workers");
        return say("worker killed");
    }
  }
  void say(const char* what) { ++ends_[what]; }

  std::unique_ptr<Process> front_;
  std::vector<std::unique_ptr<Process>> workers_;
  std::map<std::string, int> ends_;
};

TEST_F(FarmKillsTest, WhatWasAcknowledgedIsRenderedOnceToTheSameBits) {
  const char* wanted = std::getenv("QRAY_FARM_ENDS");
  const int ends = wanted ? std::atoi(wanted) : 5;
  std::mt19937 random(std::random_device{}());
  front_ = front();
  for (int i = 0; i < kWorkers; ++i) workers_.push_back(worker("workers"));
  // A few jobs of different lengths, again and again.
  std::vector<Json> kinds;
  for (int i = 0; i < 4; ++i) kinds.push_back(job(400 << i, 10 + i, i % 2 ? "none" : "adaptive"));
  // And some that the workers sample together.
  for (int i = 0; i < 4; ++i) {
    kinds.push_back(job(100 << i, 20 + i, i % 2 ? "none" : "adaptive"));
    kinds.back().update({{"workers", "auto"}, {"width", 150}, {"height", 130}});
  }
  std::vector<std::pair<std::string, size_t>> acknowledged;
  for (int i = 0; i < ends; ++i) {
    for (int j = 0; j < 2; ++j) {
      const size_t kind = random() % kinds.size();
      acknowledged.emplace_back(
          submit_surely(*front_, kinds[kind], std::to_string(i) + "-" + std::to_string(j)), kind);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 800));
    end_something(random);
  }
  std::set<std::string> blamed;
  for (const auto& [id, kind] : acknowledged) {
    const Json job = end_of(*front_, id);
    // One that happens to be under way at three kills is given up as their cause, in words.
    const std::string error = job["error"].dump();
    if (job["state"] == "failed" && error.find("the server ended 3 times") != std::string::npos) {
      blamed.insert(id);
    } else {
      EXPECT_EQ(job["state"], "succeeded") << id << " " << error;
    }
  }
  EXPECT_LE(blamed.size(), 1 + acknowledged.size() / 10);
  std::vector<std::string> alone;
  for (const Json& kind : kinds) alone.push_back(picture_alone(kind));
  for (const auto& [id, kind] : acknowledged) {
    if (!blamed.contains(id)) {
      EXPECT_EQ(picture(id), alone[kind]) << id;
    }
  }
  const std::set<std::pair<std::string, size_t>> different(acknowledged.begin(),
                                                           acknowledged.end());
  EXPECT_EQ(different.size(), acknowledged.size());
  uint64_t listed = 0;
  for (const auto& entry : std::filesystem::directory_iterator(config_.data / "results"))
    listed += entry.is_directory();
  EXPECT_GE(listed, acknowledged.size() - blamed.size());
  EXPECT_LE(listed, acknowledged.size());
  for (const auto& [what, count] : ends_) std::printf("%s: %d\n", what.c_str(), count);
  std::printf("jobs: %zu, given up: %zu\n", acknowledged.size(), blamed.size());
}

}  // namespace
}  // namespace qray::server
