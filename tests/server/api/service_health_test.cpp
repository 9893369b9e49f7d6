// What operators see: version, readiness, metrics, request ids and headers.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

const Json kTinyJob = {
    {"scene", "box"}, {"width", 32}, {"height", 32}, {"samples", 8}, {"learning_samples", 8}};

// The metrics, once they have this line: a request is counted after its answer.
std::string metrics_with(const TestService& s, const std::string& line) {
  std::string text;
  for (int i = 0; i < 200; ++i) {
    text = s.client().Get("/metrics")->body;
    if (text.find("\n" + line + "\n") != std::string::npos) return text;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ADD_FAILURE() << "no line '" << line << "' in\n" << text;
  return text;
}

double value_of(const std::string& metrics, const std::string& name) {
  const size_t at = metrics.find("\n" + name + " ");
  if (at != std::string::npos) return std::stod(metrics.substr(at + name.size() + 2));
  ADD_FAILURE() << "no " << name << " in\n" << metrics;
  return 0;
}

TEST(ServiceHealth, SaysWhichServerItIs) {
  TestService s;
  s.start();
  const Json version = s.get("/v1/");
  EXPECT_EQ(version["name"], "qray");
  EXPECT_EQ(version["version"], QRAY_VERSION);
  EXPECT_FALSE(version["commit"].get<std::string>().empty());
}

TEST(ServiceHealth, ReadyUnlessTheDiskIsFull) {
  TestService s;
  s.start();
  EXPECT_EQ(s.get("/readyz")["status"], "ready");
  s.stop();
  s.config.min_free_mib = size_t{1} << 40;
  s.start();
  const Json problem = s.get("/readyz", 503);
  EXPECT_NE(problem["detail"].get<std::string>().find("MiB free"), std::string::npos);
  EXPECT_EQ(s.get("/healthz")["status"], "ok");
}

TEST(ServiceHealth, NotReadyWhileTheDatabaseCannotBeWritten) {
  TestService s;
  s.start();
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((s.config.data / "qray.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_EQ(s.get("/readyz", 503)["detail"], "the database cannot be written");
  sqlite3_close(other);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // a look is good for a second
  EXPECT_EQ(s.get("/readyz")["status"], "ready");
}

TEST(ServiceHealth, CountsJobsRequestsAndTables) {
  TestService s;
  s.start();
  s.wait_end(s.submit(kTinyJob));
  s.wait_end(s.submit(kTinyJob));
  s.get("/v1/jobs/j000099", 404);
  s.get("/v1/nothing-of-this-name", 404);
  const std::string text = metrics_with(
      s, R"(qray_http_requests_total{method="GET",route="/v1/jobs/{id}",status="404"} 1)");
  EXPECT_EQ(value_of(text, R"(qray_jobs{state="succeeded"})"), 2);
  EXPECT_EQ(value_of(text, R"(qray_jobs{state="queued"})"), 0);
  EXPECT_EQ(value_of(text, "qray_queue_age_seconds"), 0);
  EXPECT_EQ(value_of(text, R"(qray_table_starts_total{kind="cold"})"), 1);
  EXPECT_EQ(value_of(text, R"(qray_table_starts_total{kind="warm"})"), 1);
  EXPECT_GT(value_of(text, R"(qray_rays_total{phase="rendering"})"), 1000);
  EXPECT_GT(value_of(text, R"(qray_job_seconds_total{phase="prepare"})"), 0);
  EXPECT_EQ(
      value_of(text, R"(qray_http_requests_total{method="POST",route="/v1/jobs",status="202"})"),
      2);
  EXPECT_GT(value_of(text, "qray_http_sent_bytes_total"), 1000);
  EXPECT_GT(value_of(text, "qray_connections"), 0);
  EXPECT_EQ(value_of(text, "qray_event_streams"), 0);
  EXPECT_GT(value_of(text, "process_resident_memory_bytes"), 1e6);
  EXPECT_GT(value_of(text, "process_open_fds"), 3);
  EXPECT_EQ(text.find("nothing-of-this-name"), std::string::npos);
}

TEST(ServiceHealth, AnExtendedJobIsCountedOnceAndACanceledOneAsSuch) {
  TestService s;
  s.start();
  Json request = kTinyJob;
  request["method"] = "none";
  request["samples"] = 64;
  const std::string id = s.submit(request);
  s.wait_end(id);
  const std::string ended = R"(qray_jobs_ended_total{state="succeeded"})";
  const char* rays = R"(qray_rays_total{phase="rendering"})";
  const double first = value_of(metrics_with(s, ended + " 1"), rays);
  s.post("/v1/jobs/" + id + "/extend", R"({"samples":4})", 202);
  const double both = value_of(metrics_with(s, ended + " 2"), rays);
  EXPECT_GT(both, first);
  EXPECT_LT(both, 1.3 * first);
  request["samples"] = 1'000'000;
  const std::string running = s.submit(request), queued = s.submit(request);
  s.wait(running, {"rendering"});
  for (const std::string& one : {queued, running}) s.post("/v1/jobs/" + one + "/cancel", "", 202);
  const std::string text = metrics_with(s, R"(qray_jobs_ended_total{state="canceled"} 2)");
  EXPECT_EQ(value_of(text, ended), 2);
}

TEST(ServiceHealth, EveryAnswerHasARequestId) {
  TestService s;
  s.start();
  const auto id_for = [&](const std::string& path, const std::string& given) {
    const auto answer = s.client().Get(path, {{"X-Request-Id", given}});
    EXPECT_EQ(answer->get_header_value_count("X-Request-Id"), 1u);
    return answer->get_header_value("X-Request-Id");
  };
  EXPECT_EQ(id_for("/v1/jobs", "a-1_b.C"), "a-1_b.C");
  EXPECT_EQ(id_for("/v1/nothing", "abc"), "abc");
  for (const std::string& bad : {std::string(65, 'a'), std::string("a b"), std::string("a\"b")}) {
    const std::string made = id_for("/v1/jobs", bad);
    EXPECT_EQ(made.size(), 16u) << made;
    EXPECT_NE(made, id_for("/v1/jobs", bad));
  }
  test::RawConnection c(s.service->port());
  c.send("GET / HTTP/2.0\r\nHost: localhost\r\n\r\n");
  EXPECT_NE(c.read_all().find("\r\nX-Request-Id: "), std::string::npos);
}

TEST(ServiceHealth, SecurityHeaders) {
  TestService s;
  s.start();
  for (const char* path : {"/", "/v1/jobs", "/v1/nothing", "/healthz"}) {
    const auto answer = s.client().Get(path);
    EXPECT_EQ(answer->get_header_value("X-Content-Type-Options"), "nosniff") << path;
    EXPECT_EQ(answer->get_header_value("Referrer-Policy"), "no-referrer") << path;
    EXPECT_EQ(answer->get_header_value("Cross-Origin-Resource-Policy"), "same-origin") << path;
    EXPECT_EQ(answer->get_header_value_count("Content-Security-Policy"), 1u) << path;
    EXPECT_FALSE(answer->has_header("Access-Control-Allow-Origin")) << path;
  }
}

}  // namespace
}  // namespace qray::server
