// Steps of a job's life that tests of stores take.
#pragma once

#include <gtest/gtest.h>

#include <atomic>

#include "server/store/event_log.h"
#include "server/store/job_store.h"
#include "tests/support/scratch.h"

namespace qray::server::test {

class JobStoreSteps : public ::testing::Test {
 protected:
  // As the server does at a start.
  void recover(JobStore& store) {
    store_ = &store;
    const Result<std::vector<JobRecord>> recovered = store.recover();
    ASSERT_TRUE(recovered.ok()) << recovered.error().text();
    recovered_.clear();
    for (const JobRecord& job : recovered.value()) recovered_.push_back(job.id);
  }
  JobId insert(const JobRequest& request, const std::optional<JobStore::IdempotencyKey>& key = {}) {
    const JobStore::Posted posted{request, key};
    auto inserted = store_->insert({&posted, 1}, 1);
    EXPECT_TRUE(inserted[0].ok());
    return inserted[0].ok() ? inserted[0].value().job.id : JobId{};
  }
  JobId insert() {
    JobRequest request;
    request.set(field::kScene, "box");
    request.set(field::kSamples, 8);
    return insert(request);
  }
  JobRecord get(JobId id) {
    Result<JobRecord> job = store_->get(id);
    EXPECT_TRUE(job.ok());
    return job.value();
  }
  void move(JobId id, std::initializer_list<JobState> states) {
    for (JobState to : states) {
      const Result<JobRecord> moved = store_->move(id, to);
      ASSERT_TRUE(moved.ok()) << moved.error().text();
    }
  }
  std::vector<std::string> kinds_after(uint64_t cursor) {
    std::vector<std::string> kinds;
    for (const Event& e : events_->wait(cursor, "", std::chrono::milliseconds(0)).events)
      kinds.push_back(e.kind);
    return kinds;
  }

  qray::test::ScratchFolder scratch_;
  std::atomic<int64_t> now_ms_ = 1000;  // stores have threads that ask
  std::unique_ptr<EventLog> events_;
  JobStore* store_ = nullptr;  // that was recovered last
  std::vector<JobId> recovered_;
};

}  // namespace qray::server::test
