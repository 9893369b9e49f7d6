// The JSON of requests. What is accepted is the same after a turn as text.
#include "proto/messages.h"
#include "tests/fuzz/fuzz.h"

namespace qray::fuzz {
namespace {

void expect_said_why(const proto::Problem& problem) {
  QRAY_CHECK(problem.status >= 400 && problem.status < 500);
  QRAY_CHECK(!problem.title.empty());
  for (const proto::FieldError& field : problem.errors) QRAY_CHECK(!field.detail.empty());
  QRAY_CHECK(!problem_to_json(problem).empty());
}

void run(std::string_view json) {
  const proto::RequestLimits limits;
  const auto merge = proto::parse_merge_request(json, limits);
  if (const auto* problem = std::get_if<proto::Problem>(&merge)) expect_said_why(*problem);

  const auto stored = proto::parse_stored_request(json);
  if (const auto* problem = std::get_if<proto::Problem>(&stored)) expect_said_why(*problem);

  const auto parsed = proto::parse_job_request(json, limits);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed)) return expect_said_why(*problem);
  const auto& request = std::get<JobRequest>(parsed);
  const auto again = proto::parse_job_request(proto::job_request_to_json(request), limits);
  QRAY_CHECK(std::holds_alternative<JobRequest>(again));
  QRAY_CHECK(std::get<JobRequest>(again) == request);
}

}  // namespace
}  // namespace qray::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  qray::fuzz::run(qray::fuzz::as_text({data, size}));
  return 0;
}
