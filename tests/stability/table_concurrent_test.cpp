// Two jobs at once that start from one table.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/server/test_service.h"
#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

struct Made {
  std::vector<float> pixels;
  std::string table, parent;
  bool operator==(const Made&) const = default;
};

Made run_one(const PreparedScene& scene, const RenderSettings& settings, const TableFile& table) {
  Film film(settings.width, settings.height);
  TaskPool pool(2);
  RenderObserver observer;
  Result<JobResult> job = run_job(scene, settings, table, film, pool, observer, {}, SteadyClock());
  if (!job.ok()) return {{}, job.error().text(), ""};
  const Image image = film.develop();
  const TableHeader& header = job.value().table->header;
  return {{image.data().begin(), image.data().end()}, header.id, header.parents.at(0)};
}

TEST(TableConcurrent, JobsInOneProcessDoNotDisturbEachOther) {
  const test::FailureMode mode("concurrent-jobs");
  constexpr size_t kJobs = 3;
  const auto scene = test::prepare(test::room());
  for (const std::string& method : test::learning_methods()) {
    RenderSettings settings[kJobs];
    for (size_t i = 0; i < kJobs; ++i)
      settings[i] = test::variant_settings(method, 48, 32, 800 + i);
    const TableFile table = *test::learned_table(*scene, settings[0], method);
    Made alone[kJobs], together[kJobs];
    for (size_t i = 0; i < kJobs; ++i) alone[i] = run_one(*scene, settings[i], table);
    {
      std::vector<std::jthread> threads;
      for (size_t i = 0; i < kJobs; ++i)
        threads.emplace_back([&, i] { together[i] = run_one(*scene, settings[i], table); });
    }
    for (size_t i = 0; i < kJobs; ++i) {
      EXPECT_EQ(together[i], alone[i]) << method << ", job " << i;
      EXPECT_EQ(together[i].parent, table.header.id) << method;
    }
    EXPECT_NE(alone[0].table, alone[1].table) << method;
    mode.says(method, "three jobs at once make the bits of three jobs in turn");
  }
}

TEST(TableConcurrent, JobsOfTheServerDoNotDisturbEachOther) {
  using server::test::Json;
  server::test::TestService s;
  s.start();
  for (std::string_view method : method_names()) {
    if (method == "none") continue;
    const Json request = {
        {"scene", "box"}, {"width", 48}, {"height", 48}, {"samples", 32}, {"method", method}};
    const auto with = [&](int seed, const std::string& table) {
      Json job = request;
      job["seed"] = seed;
      job["table"] = table;
      return s.submit(job);
    };
    const auto picture = [&](const std::string& id) {
      const auto answer = s.client().Get("/v1/jobs/" + id + "/image.png");
      return answer && answer->status == 200 ? answer->body : "";
    };
    const std::string parent = s.wait_end(s.submit(request))["table_out"];
    std::vector<std::string> one_by_one, at_once;
    for (int seed : {2, 3}) {
      one_by_one.push_back(with(seed, parent));
      s.wait_end(one_by_one.back());
    }
    for (int seed : {2, 3}) at_once.push_back(with(seed, parent));  // both wait or run
    for (size_t i = 0; i < at_once.size(); ++i) {
      const Json job = s.wait_end(at_once[i]), before = s.wait_end(one_by_one[i]);
      EXPECT_EQ(job["state"], "succeeded") << method << ": " << job.dump();
      EXPECT_EQ(job["table_in"], parent) << method;
      EXPECT_EQ(job["table_out"], before["table_out"]) << method;
      EXPECT_FALSE(picture(at_once[i]).empty());
      EXPECT_EQ(picture(at_once[i]), picture(one_by_one[i])) << method << ", job " << i;
      const Json tables = s.get("/v1/tables")["tables"];
      const auto table = std::find_if(tables.begin(), tables.end(),
                                      [&](const Json& t) { return t["id"] == job["table_out"]; });
      ASSERT_NE(table, tables.end()) << method;
      EXPECT_EQ((*table)["parents"], Json::array({parent})) << method;
      // The same table as before: its newer record took the older one's place.
      EXPECT_EQ((*table)["job"], at_once[i]) << method;
    }
    EXPECT_NE(s.wait_end(at_once[0])["table_out"], s.wait_end(at_once[1])["table_out"]);
  }
}

}  // namespace
}  // namespace qray
