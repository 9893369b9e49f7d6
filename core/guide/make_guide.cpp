#include <algorithm>
#include <array>

#include "core/guide/adaptive.h"
#include "core/guide/dahm_keller.h"
#include "core/guide/huang.h"
#include "core/guide/ppg.h"

namespace qray {
namespace {
constexpr std::array<std::string_view, 6> kMethods = {
    "none", "huang-published", "huang", "dahm-keller", "ppg", "adaptive"};
}  // namespace

Status Guide::merge(const Guide& other) {
  if (other.method() != method())
    return Error{ErrorCode::kInvalid,
                 "a table of method '" + std::string(other.method()) +
                     "' cannot be merged into one of '" + std::string(method()) + "'",
                 "table"};
  return Error{ErrorCode::kInvalid,
               "tables of method '" + std::string(method()) + "' cannot be merged", "table"};
}

std::vector<GuidePoint> spread_over(std::vector<GuidePoint> points, size_t most) {
  const size_t known = points.size(), count = std::min(known, most);
  for (size_t i = 0; i < count; ++i) points[i] = points[i * known / count];
  points.resize(count);
  return points;
}

std::span<const std::string_view> method_names() { return kMethods; }

std::string_view table_method(std::string_view method) {
  return method == "huang-published" ? "huang" : method;
}

Result<std::unique_ptr<Guide>> make_guide(std::string_view method, const GuideSetup& setup) {
  const auto huang = [&setup](HuangGuide::Density density) {
    return std::make_unique<HuangGuide>(density, setup.bounds, setup.huang, setup.max_bytes);
  };
  std::unique_ptr<Guide> guide;
  if (method == "none") return guide;
  if (method == "huang-published") guide = huang(HuangGuide::Density::kAsPublished);
  if (method == "huang") guide = huang(HuangGuide::Density::kExact);
  if (method == "dahm-keller") guide = std::make_unique<DahmKellerGuide>(setup);
  if (method == "ppg") guide = std::make_unique<PpgGuide>(setup);
  if (method == "adaptive") guide = std::make_unique<AdaptiveGuide>(setup);
  if (guide) return guide;
  std::string known;
  for (std::string_view name : kMethods) known += (known.empty() ? "" : ", ") + std::string(name);
  return Error{ErrorCode::kInvalid,
               "unknown method '" + std::string(method) + "', expected one of " + known, "/method"};
}

}  // namespace qray
