#include "core/render/settings.h"

#include <cmath>
#include <string>

#include "core/guide/surface_grid.h"
#include "core/scene/validate.h"

namespace qray {
namespace {

constexpr int kMaxDepth = 128;
constexpr int kMaxSidePx = 8192;
constexpr double kMaxSeconds = 24 * 3600;
constexpr double kMaxTableBytes = 1e12;

Status check_range(double value, double lo, double hi, const char* pointer) {
  if (value >= lo && value <= hi) return {};  // false for NaN
  const auto text = [](double v) {
    std::string s = std::to_string(v);
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
    return s;
  };
  return Error{ErrorCode::kInvalid,
               "expected " + text(lo) + ".." + text(hi) + ", got " + text(value), pointer};
}

constexpr std::pair<Pixels, std::string_view> kPixels[] = {
    {Pixels::kAll, "all"}, {Pixels::kQuarter, "quarter"}, {Pixels::kAdaptive, "adaptive"}};
}  // namespace

std::string_view pixels_name(Pixels pixels) {
  for (const auto& [p, name] : kPixels)
    if (p == pixels) return name;
  return "";
}
std::optional<Pixels> pixels_named(std::string_view wanted) {
  for (const auto& [p, name] : kPixels)
    if (name == wanted) return p;
  return {};
}

Status check_settings(const RenderSettings& s, int64_t max_pixels) {
  struct Check {
    double value, lo, hi;
    const char* pointer;
  };
  const Check checks[] = {
      {static_cast<double>(s.width), 1, kMaxSidePx, "/width"},
      {static_cast<double>(s.height), 1, kMaxSidePx, "/height"},
      {static_cast<double>(s.samples), s.seconds > 0 ? 0.0 : 1.0, kMaxSamples, "/samples"},
      {s.seconds, 0, kMaxSeconds, "/seconds"},
      {s.noise, 0, 1, "/noise"},
      {static_cast<double>(s.max_depth), 1, kMaxDepth, "/max_depth"},
      {static_cast<double>(s.learning_samples), 0, kMaxSamples, "/learning_samples"},
      {static_cast<double>(s.max_table_bytes), 1, kMaxTableBytes, "/max_table_bytes"},
      {s.huang.alpha, 0, 1, "/alpha"},
      {s.huang.gamma, 0, 1, "/gamma"},
      {static_cast<double>(s.huang.grid), 1, SurfaceGrid::kMaxGrid, "/grid"},
  };
  for (const Check& c : checks)
    if (Status status = check_range(c.value, c.lo, c.hi, c.pointer); !status.ok()) return status;
  for (const auto& [side, pointer] : {std::pair{s.width, "/width"}, {s.height, "/height"}})
    if (s.pixels != Pixels::kAll && side % 2 != 0)
      return Error{ErrorCode::kInvalid,
                   "expected an even number, as only a quarter of the pixels is sampled, got " +
                       std::to_string(side),
                   pointer};
  if (static_cast<int64_t>(s.width) * s.height > max_pixels) {
    return Error{ErrorCode::kTooLarge,
                 "expected at most " + std::to_string(max_pixels) + " pixels, got " +
                     std::to_string(static_cast<int64_t>(s.width) * s.height),
                 "/width"};
  }
  for (int pass : s.passes)
    if (Status status = check_range(pass, 1, kMaxSamples, "/passes"); !status.ok()) return status;
  if (s.camera) {
    if (Status status = validate_camera(*s.camera); !status.ok()) return status;
  }
  return {};
}

}  // namespace qray
