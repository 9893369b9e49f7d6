#include "server/model/job.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

constexpr JobState kAll[] = {JobState::kQueued,    JobState::kPreparing,  JobState::kLearning,
                             JobState::kRendering, JobState::kFinalizing, JobState::kSucceeded,
                             JobState::kPausing,   JobState::kPaused,     JobState::kCanceling,
                             JobState::kCanceled,  JobState::kFailed};

TEST(Job, EndedJobsStayAsTheyAre) {
  for (JobState from : kAll) {
    bool moves = false;
    for (JobState to : kAll) moves |= can_move(from, to);
    // But more may be asked of one that has succeeded.
    EXPECT_EQ(moves, !has_ended(from) || from == JobState::kSucceeded) << to_string(from);
  }
  for (JobState to : kAll)
    EXPECT_EQ(can_move(JobState::kSucceeded, to), to == JobState::kQueued) << to_string(to);
}

TEST(Job, RunningJobsCanBeCanceledFailedOrPutBack) {
  using enum JobState;
  for (JobState from : {kPreparing, kLearning, kRendering, kFinalizing}) {
    for (JobState to : {kCanceling, kFailed, kQueued}) EXPECT_TRUE(can_move(from, to));
    EXPECT_FALSE(can_move(from, kCanceled)) << to_string(from);
    EXPECT_FALSE(can_move(from, from));
  }
  EXPECT_TRUE(can_move(kQueued, kCanceled));
  EXPECT_FALSE(can_move(kQueued, kRendering));
  EXPECT_FALSE(can_move(kRendering, kLearning));
  EXPECT_FALSE(can_move(kCanceling, kSucceeded));
  for (JobState from : {kPreparing, kLearning, kRendering}) EXPECT_TRUE(can_move(from, kPausing));
  EXPECT_FALSE(can_move(kFinalizing, kPausing));
  EXPECT_TRUE(can_move(kPausing, kCanceling));
  EXPECT_FALSE(can_move(kPausing, kQueued));
  EXPECT_TRUE(can_move(kPaused, kQueued));
  EXPECT_FALSE(is_running(kPaused));
}

TEST(Job, StateNames) {
  for (JobState state : kAll) EXPECT_EQ(parse_job_state(to_string(state)), state);
  EXPECT_EQ(parse_job_state("done"), std::nullopt);
}

TEST(Job, Ids) {
  EXPECT_EQ(JobId{1}.text(), "j000001");
  EXPECT_EQ(JobId{1234567}.text(), "j1234567");
  EXPECT_EQ(JobId::parse("j000001"), JobId{1});
  EXPECT_EQ(JobId::parse("j1234567"), JobId{1234567});
  for (const char* text : {"", "j", "1", "j1", "j0000001", "j00001x", "J000001", "j-00001",
                           "j99999999999999999999", "j000001 "}) {
    EXPECT_EQ(JobId::parse(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace qray::server
