// The files of a chart's folder, so that who writes them and who shows them agree:
//   reference.png, <method>[-warm].png and <method>[-warm]-error.png in a folder for each scene.
// Paths are relative to the chart's folder. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace qray {

// A name as a file name: in small letters; what is outside [a-z0-9.-] becomes '-'.
inline std::string chart_file_name(std::string_view name) {
  std::string out(name);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
    if (!kept) c = '-';
  }
  return out;
}

inline std::filesystem::path chart_reference_picture(std::string_view scene) {
  return std::filesystem::path(chart_file_name(scene)) / "reference.png";
}
// The last picture of the first seed; `method` as in ChartRow.
inline std::filesystem::path chart_picture(std::string_view scene, std::string_view method,
                                           bool warm) {
  return std::filesystem::path(chart_file_name(scene)) /
         (chart_file_name(method) + (warm ? "-warm.png" : ".png"));
}
// Its error: see core/image/difference_map.h.
inline std::filesystem::path chart_error_picture(std::string_view scene, std::string_view method,
                                                 bool warm) {
  return std::filesystem::path(chart_file_name(scene)) /
         (chart_file_name(method) + (warm ? "-warm-error.png" : "-error.png"));
}

}  // namespace qray
