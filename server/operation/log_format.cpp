#include "server/operation/log_format.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>

#include "proto/json_text.h"
#include "proto/messages.h"

namespace qray::server {
namespace {

void append(spdlog::memory_buf_t& out, std::string_view text) {
  out.append(text.data(), text.data() + text.size());
}

// Control characters as \xNN.
class OneLine final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& out) override {
    for (const char c : message.payload) {
      if (static_cast<unsigned char>(c) >= 32 && c != 127) {
        out.push_back(c);
        continue;
      }
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned char>(c));
      append(out, escaped);
    }
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<OneLine>();
  }
};

bool is_member_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
}

class JsonLines final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const auto ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(message.time.time_since_epoch());
    const auto level = spdlog::level::to_string_view(message.level);
    std::vector<proto::JsonField> fields = {
        {"time", proto::time_to_text(ms.count())},
        {"level", std::string(level.data(), level.size())},
    };
    std::string_view rest(message.payload.data(), message.payload.size());
    while (!rest.empty()) {
      const std::string_view word = rest.substr(0, rest.find(' '));
      const size_t equals = word.find('=');
      if (equals == std::string_view::npos || !is_member_name(word.substr(0, equals))) break;
      fields.emplace_back(word.substr(0, equals), std::string(word.substr(equals + 1)));
      rest.remove_prefix(std::min(word.size() + 1, rest.size()));
    }
    if (!rest.empty()) fields.emplace_back("message", std::string(rest));
    append(out, proto::json_object(fields, /*indent=*/false));
    out.push_back('\n');
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonLines>();
  }
};

}  // namespace

std::unique_ptr<spdlog::formatter> log_formatter(const std::string& format) {
  if (format == "json") return std::make_unique<JsonLines>();
  auto text = std::make_unique<spdlog::pattern_formatter>();
  text->add_flag<OneLine>('*').set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %l %*");
  return text;
}

void set_up_log(const std::string& format, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("qrayd"));
  spdlog::set_formatter(log_formatter(format));
  spdlog::set_level(spdlog::level::from_str(level));
}

}  // namespace qray::server
