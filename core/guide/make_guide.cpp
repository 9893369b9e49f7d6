#include <array>

#include "core/guide/huang.h"

namespace qray {
namespace {
constexpr std::array<std::string_view, 3> kMethods = {"none", "huang-published", "huang"};
}

std::span<const std::string_view> method_names() { return kMethods; }

std::string_view table_method(std::string_view method) {
  return method == "huang-published" ? "huang" : method;
}

Result<std::unique_ptr<Guide>> make_guide(std::string_view method, const Bounds3& bounds,
                                          const HuangParams& huang, size_t max_bytes) {
  using Density = HuangGuide::Density;
  if (method == "none") return std::unique_ptr<Guide>();
  if (method == "huang") {
    return std::unique_ptr<Guide>(
        std::make_unique<HuangGuide>(Density::kExact, bounds, huang, max_bytes));
  }
  if (method == "huang-published") {
    return std::unique_ptr<Guide>(
        std::make_unique<HuangGuide>(Density::kAsPublished, bounds, huang, max_bytes));
  }
  std::string known;
  for (std::string_view name : kMethods) known += (known.empty() ? "" : ", ") + std::string(name);
  return Error{ErrorCode::kInvalid,
               "unknown method '" + std::string(method) + "', expected one of " + known, "/method"};
}

}  // namespace qray
