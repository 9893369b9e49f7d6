#include "server/config.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/guide/guide.h"

namespace qray::server {
namespace {

ParsedConfig parse(std::vector<const char*> args) {
  args.insert(args.begin(), "qrayd");
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  ParsedConfig parsed = parse_config(static_cast<int>(args.size()), args.data());
  ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return parsed;
}

TEST(Config, Defaults) {
  const ParsedConfig parsed = parse({});
  ASSERT_TRUE(parsed.config);
  EXPECT_EQ(parsed.config->host, "127.0.0.1");
  EXPECT_EQ(parsed.config->port, 8080);
  EXPECT_EQ(parsed.config->max_queued, 1000u);
  EXPECT_EQ(parsed.config->table_mib << 20, kDefaultTableBytes);
  EXPECT_EQ(parsed.config->web.filename(), "web");
}

TEST(Config, Options) {
  const ParsedConfig parsed =
      parse({"--port", "0", "--data", "d", "--threads", "3", "--scenes", "s", "--web", "w",
             "--max-queued", "5", "--table-mib", "2", "--host", "::1"});
  ASSERT_TRUE(parsed.config);
  EXPECT_EQ(parsed.config->port, 0);
  EXPECT_EQ(parsed.config->data, "d");
  EXPECT_EQ(parsed.config->threads, 3);
  EXPECT_EQ(parsed.config->scenes, "s");
  EXPECT_EQ(parsed.config->max_queued, 5u);
  EXPECT_EQ(parsed.config->table_mib, 2u);
}

TEST(Config, WrongOptions) {
  for (const auto& args : std::vector<std::vector<const char*>>{
           {"--port", "70000"}, {"--port", "x"}, {"--threads", "-1"}, {"--bogus"}, {"extra"}}) {
    const ParsedConfig parsed = parse(args);
    EXPECT_FALSE(parsed.config);
    EXPECT_NE(parsed.exit_code, 0);
  }
  const ParsedConfig help = parse({"--help"});
  EXPECT_FALSE(help.config);
  EXPECT_EQ(help.exit_code, 0);
}

}  // namespace
}  // namespace qray::server
