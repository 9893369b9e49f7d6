// How qrayd's log looks: lines of text, or of JSON, where the name=value words that a message
// begins with become members. What came from clients cannot break a line. Called once, by main().
#pragma once

#include <spdlog/formatter.h>

#include <memory>
#include <string>

namespace qray::server {

// `format`: "text" or "json"; `level`: debug, info, warn or error.
void set_up_log(const std::string& format, const std::string& level);
std::unique_ptr<spdlog::formatter> log_formatter(const std::string& format);

}  // namespace qray::server
