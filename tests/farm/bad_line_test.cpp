// A farm whose lines to the database are bad: they delay, break within a message, are closed one
// way, fall silent. Whatever was acknowledged is rendered once to the bits of a server alone.
// QRAY_BAD_LINE_JOBS=40 has so many jobs.
#include <random>

#include "tests/farm/farm.h"
#include "tests/support/bad_line.h"

namespace qray::server {
namespace {

using test::FarmTest;
using test::Json;
using test::Process;

TEST_F(FarmTest, OverABadLineJobsEndOnceWithTheSameBits) {
  qray::test::BadLine line(postgres_->socket());
  const std::string schema = postgres_->new_schema();
  config_.store = postgres_->url(schema, line.folder());
  const auto front = this->front(), first = worker("workers"), second = worker("workers");
  const uint64_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  line.go_bad(seed);

  const char* wanted = std::getenv("QRAY_BAD_LINE_JOBS");
  const int jobs = wanted ? std::atoi(wanted) : 4;
  std::vector<Json> requests;
  for (int i = 0; i < jobs; ++i) {
    requests.push_back(job(100 << (i % 4), 10 + i, i % 2 ? "none" : "adaptive"));
    if (i % 4 < 2) requests.back().update({{"workers", "auto"}, {"width", 150}, {"height", 130}});
  }
  std::vector<std::string> ids;
  for (size_t i = 0; i < requests.size(); ++i)
    ids.push_back(submit_surely(*front, requests[i], std::to_string(i)));
  for (const std::string& id : ids) EXPECT_EQ(end_of(*front, id)["state"], "succeeded") << id;
  line.be_good();
  EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), ids.size());
  EXPECT_EQ(front->get("/v1/jobs?limit=200")["jobs"].size(), ids.size());
  for (size_t i = 0; i < ids.size(); ++i)
    EXPECT_EQ(picture(ids[i]), picture_alone(requests[i])) << requests[i];
  int all = 0;
  for (const auto& [what, count] : line.ends()) {
    std::printf("%s: %d\n", what.c_str(), count);
    all += count;
  }
  EXPECT_GT(all, jobs);
}

}  // namespace
}  // namespace qray::server
