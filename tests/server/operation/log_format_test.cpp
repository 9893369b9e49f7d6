#include "server/operation/log_format.h"

#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace qray::server {
namespace {

std::string logged(const std::string& format, const std::string& message) {
  std::ostringstream out;
  spdlog::logger logger("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(out));
  logger.set_formatter(log_formatter(format));
  logger.warn("{}", message);
  return out.str();
}

TEST(LogFormat, TextStaysOnItsLine) {
  const std::string line = logged("text", "job=j1 a\nb\x1b[31m");
  EXPECT_TRUE(line.ends_with(" warning job=j1 a\\x0ab\\x1b[31m\n")) << line;
}

TEST(LogFormat, LeadingWordsAreMembersOfJson) {
  const auto json = nlohmann::json::parse(logged("json", "job=j1 ms=2.5 a \"b\"\n c=d \xff"));
  EXPECT_EQ(json["level"], "warning");
  EXPECT_EQ(json["job"], "j1");
  EXPECT_EQ(json["ms"], "2.5");
  EXPECT_EQ(json["message"], "a \"b\"\n c=d \xEF\xBF\xBD");
  EXPECT_EQ(json["time"].get<std::string>().size(), 24u);
  EXPECT_FALSE(nlohmann::json::parse(logged("json", "request=1 status=200")).contains("message"));
}

}  // namespace
}  // namespace qray::server
