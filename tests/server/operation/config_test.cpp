#include "server/operation/config.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/support/places.h"
#include "tests/support/scratch.h"

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
  EXPECT_GT(parsed.config->table_mib, 64u);  // a sixteenth of what there is
  EXPECT_LT(parsed.config->table_mib, 1u << 19);
  // As many jobs and sessions as there may be learn at once, with room for their pictures.
  EXPECT_GT(parsed.config->jobs_mib,
            (static_cast<size_t>(parsed.config->jobs_at_once) + parsed.config->live_sessions) *
                parsed.config->table_mib);
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

// Set while this lives.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
  ~Variable() { ::unsetenv(name_); }

 private:
  const char* name_;
};

TEST(Config, CommandLineOverEnvironmentOverFile) {
  const qray::test::ScratchFolder scratch;
  const std::string file = (scratch / "qrayd.toml").string();
  std::ofstream(file) << "# limits\nport = 1001\nmax-queued = 11\njson-mib = 2\nhost = \"::1\"\n";
  const Variable config("QRAYD_CONFIG", file.c_str());
  const Variable port("QRAYD_PORT", "1002"), queued("QRAYD_MAX_QUEUED", "12");
  const ParsedConfig parsed = parse({"--port", "1003"});
  ASSERT_TRUE(parsed.config);
  EXPECT_EQ(parsed.config->port, 1003);
  EXPECT_EQ(parsed.config->max_queued, 12u);
  EXPECT_EQ(parsed.config->json_mib, 2u);
  EXPECT_EQ(parsed.config->host, "::1");
  const auto said = [&](const std::string& line) {
    return std::find(parsed.effective.begin(), parsed.effective.end(), line) !=
           parsed.effective.end();
  };
  for (const char* line : {"port=1003", "max-queued=12", "json-mib=2", "host=::1", "imports=1"})
    EXPECT_TRUE(said(line)) << line;
}

TEST(Config, WrongFilesAndVariables) {
  const qray::test::ScratchFolder scratch;
  const std::string file = (scratch / "qrayd.toml").string();
  for (const char* text : {"prot = 80", "port = 70000", "max-queued = x", "port"}) {
    std::ofstream(file) << text << "\n";
    EXPECT_FALSE(parse({"--config", file.c_str()}).config) << text;
  }
  EXPECT_FALSE(parse({"--config", (scratch / "none.toml").c_str()}).config);
  const Variable streams("QRAYD_MAX_STREAMS", "many");
  EXPECT_FALSE(parse({}).config);
}

// docs/configuration.md has a row for each option of --help, with its default where that is not in
// words, and none besides.
TEST(Config, TheDocumentListsEveryOption) {
  std::stringstream text;
  text << std::ifstream(test::source_dir() / "docs/configuration.md").rdbuf();
  std::map<std::string, std::string> rows;
  const std::string document = text.str();
  const std::regex row(R"(\n\| `--([a-z-]+)` \| ([^|]*) \|)");
  for (std::sregex_iterator it(document.begin(), document.end(), row), end; it != end; ++it)
    rows[(*it)[1]] = (*it)[2];
  const ParsedConfig parsed = parse({});
  for (const std::string& line : parsed.effective) {
    const std::string name = line.substr(0, line.find('='));
    const auto found = rows.find(name);
    ASSERT_NE(found, rows.end()) << "no row for --" << name;
    const std::string& value = found->second;
    if (value.starts_with('`')) {
      EXPECT_EQ(name + "=" + value.substr(1, value.size() - 2), line);
    }
    rows.erase(found);
  }
  for (const char* apart : {"config", "help", "version"}) EXPECT_EQ(rows.erase(apart), 1u) << apart;
  EXPECT_TRUE(rows.empty()) << rows.begin()->first;
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
