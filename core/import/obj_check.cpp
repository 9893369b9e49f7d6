#include "core/import/obj_check.h"

#include <charconv>
#include <cmath>
#include <cstdint>

#include "core/import/import_failure.h"

namespace qray {
namespace {

constexpr int kMaxCorners = 1024;  // of one polygon: cutting ears off takes quadratic time

std::string_view next_token(std::string_view& line) {
  const size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string_view token = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return token;
}

template <class T>
bool parse(std::string_view token, T& value) {
  if (token.starts_with('+')) token.remove_prefix(1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc{} && end == token.data() + token.size();
}

class LineChecker {
 public:
  explicit LineChecker(const std::string& file) : file_(file) {}

  void check(std::string_view line) {
    ++line_number_;
    const std::string_view keyword = next_token(line);
    if (keyword == "v") {
      numbers(line, 3);
      ++counts_[0];
    } else if (keyword == "vt") {
      numbers(line, 1);
      ++counts_[1];
    } else if (keyword == "vn") {
      numbers(line, 3);
      ++counts_[2];
    } else if (keyword == "f") {
      face(line);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    fail_import(ErrorCode::kInvalid, message, file_ + ":" + std::to_string(line_number_));
  }

  void numbers(std::string_view line, int least) const {
    int count = 0;
    for (std::string_view token; !(token = next_token(line)).empty(); ++count) {
      float value = 0;
      if (!parse(token, value) || !std::isfinite(value))
        fail("expected a number, got \"" + std::string(token.substr(0, 40)) + "\"");
    }
    if (count < least)
      fail("expected " + std::to_string(least) + " numbers, got " + std::to_string(count));
  }

  void face(std::string_view line) const {
    int corners = 0;
    for (std::string_view token; !(token = next_token(line)).empty(); ++corners) corner(token);
    if (corners < 3) fail("expected at least 3 corners, got " + std::to_string(corners));
    if (corners > kMaxCorners) {
      fail("expected at most " + std::to_string(kMaxCorners) + " corners, got " +
           std::to_string(corners));
    }
  }

  // "v", "v/vt", "v//vn" or "v/vt/vn"; from 1, or from -1 backward.
  void corner(std::string_view token) const {
    static constexpr const char* kNames[] = {"position", "texture coordinate", "normal"};
    std::string_view rest = token;
    for (int i = 0; i < 3; ++i) {
      const size_t end = std::min(rest.find('/'), rest.size());
      const std::string_view part = rest.substr(0, end);
      const bool may_be_empty = i == 1 && end < rest.size();  // v//vn
      if (!part.empty() || !may_be_empty) index(part, counts_[i], kNames[i], token);
      if (end == rest.size()) return;
      rest.remove_prefix(end + 1);
    }
    fail("expected a corner like 1/2/3, got \"" + std::string(token.substr(0, 40)) + "\"");
  }

  void index(std::string_view part, int64_t count, const char* name, std::string_view token) const {
    int64_t value = 0;
    if (!parse(part, value))
      fail("expected a corner like 1/2/3, got \"" + std::string(token.substr(0, 40)) + "\"");
    if (value == 0 || value > count || value < -count) {
      fail("expected the index of one of the " + std::to_string(count) + " " + name +
           "s so far, got " + std::to_string(value));
    }
  }

  const std::string& file_;
  int64_t counts_[3] = {0, 0, 0};  // v, vt, vn
  int64_t line_number_ = 0;
};

}  // namespace

void check_obj_lines(std::string_view text, const std::string& file,
                     const std::function<void(double)>& told) {
  constexpr int kLinesBetween = 4096;
  LineChecker checker(file);
  const auto size = static_cast<double>(text.size());
  for (int64_t line = 0; !text.empty(); ++line) {
    if (line % kLinesBetween == 0) told(1 - static_cast<double>(text.size()) / size);
    // CR alone ends a line too, as the parser has it.
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    checker.check(text.substr(0, end));
    const size_t mark = text.substr(end).starts_with("\r\n") ? 2 : 1;
    text.remove_prefix(std::min(end + mark, text.size()));
  }
}

}  // namespace qray
