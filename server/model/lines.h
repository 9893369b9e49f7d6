// Lists of short texts as one text column, a line each. Pure functions.
#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace qray::server {

inline std::string join_lines(const std::vector<std::string>& lines) {
  std::string out;
  for (std::string line : lines) {
    std::replace(line.begin(), line.end(), '\n', ' ');
    out += line + "\n";
  }
  return out;
}

inline std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace qray::server
