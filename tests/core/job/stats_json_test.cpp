#include "core/job/stats_json.h"
#include "tests/support/places.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace qray {
namespace {

RenderStats some_stats() {
  RenderStats stats;
  stats.method = "huang";
  stats.seed = 18446744073709551615u;
  stats.seconds = 2;
  stats.rays = 3'000'000;
  stats.samples_per_pixel = 4;
  stats.parts = {{"nee", "on"}};
  stats.passes = {1, 1, 2};
  stats.guide_passes = {{4, true, true, 0.25, 0.5, 2, 10, 40, 3000}};
  stats.share_tracing = 0.5;
  return stats;
}

TEST(StatsJson, WritesOneLineInAFixedOrder) {
  const std::string text = stats_json(some_stats(), /*indent=*/false);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_TRUE(text.starts_with(R"({"method":"huang","unbiased":true,"nee":true,)"
                               R"("parts":{"nee":"on"},"seed":18446744073709551615,)"))
      << text;
  EXPECT_NE(text.find(R"("passes":[1,1,2])"), std::string::npos) << text;
  EXPECT_NE(text.find(R"("guide_passes":[{"samples":4,"guided":true,"learned":true,"share":0.25,)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find(R"("rays":3000000,"rays_per_second":1500000.0)"), std::string::npos) << text;
}

TEST(StatsJson, DocumentationNamesEveryField) {
  std::ifstream file(test::source_dir() / "docs/stats.md");
  std::stringstream page;
  page << file.rdbuf();
  std::istringstream lines(stats_json(some_stats()));
  int fields = 0;
  for (std::string line; std::getline(lines, line);) {
    const size_t quote = line.find('"');
    if (quote == std::string::npos || line.find("\": ") == std::string::npos) continue;
    const std::string name = line.substr(quote + 1, line.find('"', quote + 1) - quote - 1);
    EXPECT_NE(page.str().find(name + "`"), std::string::npos) << name;
    ++fields;
  }
  EXPECT_EQ(fields, 35 + 9 + 1);  // with a pass of the guide, and a part
}

}  // namespace
}  // namespace qray
