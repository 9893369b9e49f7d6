#include "core/settings/render_settings.h"

#include <string>
#include <tuple>

#include "core/scene/validate.h"
#include "core/settings/job_fields.h"

namespace qray {
namespace {

constexpr double kMaxTableBytes = 1e12;

// As many digits as the value needs.
std::string plain_text(double v) {
  std::string s = std::to_string(v);
  s.erase(s.find_last_not_of('0') + 1);
  if (s.back() == '.') s.pop_back();
  return s;
}

Status check_range(double value, double least, double most, const std::string& pointer) {
  if (value >= least && value <= most) return {};  // false for NaN
  return Error{
      ErrorCode::kInvalid,
      "expected " + plain_text(least) + ".." + plain_text(most) + ", got " + plain_text(value),
      pointer};
}

Status check_range(const Field& field, const RenderSettings& settings) {
  if (!field.setting.read) return {};
  const std::optional<FieldValue> value = field.setting.read(settings);
  if (!value) return {};
  const std::string pointer = "/" + field.path;
  if (const auto* whole = std::get_if<int64_t>(&*value))
    return check_range(static_cast<double>(*whole), field.least, field.most, pointer);
  if (const auto* number = std::get_if<double>(&*value))
    return check_range(*number, field.least, field.most, pointer);
  return {};
}

constexpr std::pair<Pixels, std::string_view> kPixels[] = {
    {Pixels::kAll, "all"}, {Pixels::kQuarter, "quarter"}, {Pixels::kByNoise, "by-noise"}};

Status check_region(const RenderSettings& s) {
  const PixelRegion& region = s.region;
  if (region.empty()) return {};
  if (s.pixels == Pixels::kByNoise)
    return Error{ErrorCode::kInvalid,
                 "expected no region where the noise decides which pixels are sampled", "/region"};
  for (const auto& [value, least, most, path] :
       {std::tuple{region.x, 0, s.width - 1, "/region/x"},
        std::tuple{region.y, 0, s.height - 1, "/region/y"},
        std::tuple{region.width, 1, s.width - region.x, "/region/width"},
        std::tuple{region.height, 1, s.height - region.y, "/region/height"}})
    if (Status status = check_range(value, least, most, path); !status.ok()) return status;
  return {};
}

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
  for (const Field& field : job_fields())
    if (Status status = check_range(field, s); !status.ok()) return status;
  if (Status status = check_range(static_cast<double>(s.max_table_bytes), 1, kMaxTableBytes,
                                  "/max_table_bytes");
      !status.ok())
    return status;
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
  if (Status status = check_region(s); !status.ok()) return status;
  for (int pass : s.passes)
    if (Status status = check_range(pass, 1, kMaxSamples, "/passes"); !status.ok()) return status;
  if (s.camera) {
    if (Status status = validate_camera(*s.camera); !status.ok()) return status;
  }
  return {};
}

}  // namespace qray
