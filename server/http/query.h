// What a request carries, checked: its type of body and its query parameters. Pure functions.
#pragma once

#include <httplib.h>

#include <charconv>
#include <optional>
#include <vector>

#include "core/base/result.h"

namespace qray::server {

inline bool is_json(const httplib::Request& req) {
  std::string type = req.get_header_value("Content-Type");
  type = type.substr(0, type.find(';'));
  while (type.ends_with(' ')) type.pop_back();
  return type == "application/json";
}

// Of a parameter that may be given several times.
inline std::vector<std::string> query_values(const httplib::Request& req, const char* name) {
  std::vector<std::string> values;
  for (size_t i = 0; i < req.get_param_value_count(name); ++i)
    values.push_back(req.get_param_value(name, i));
  return values;
}

// kInvalid names the parameter as "/name". Absent: `otherwise`.
template <class T>
Result<T> query_number(const httplib::Request& req, const char* name, T least, T most,
                       T otherwise) {
  if (!req.has_param(name)) return otherwise;
  const std::string text = req.get_param_value(name);
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc{} && stop == end && value >= least && value <= most) return value;
  return Error{ErrorCode::kInvalid,
               "expected a number, " + std::to_string(least) + ".." + std::to_string(most),
               std::string("/") + name};
}

}  // namespace qray::server
