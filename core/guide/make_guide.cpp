#include <algorithm>
#include <array>

#include "core/guide/adaptive.h"
#include "core/guide/adaptive_layout.h"
#include "core/guide/dahm_keller.h"
#include "core/guide/grid_table.h"
#include "core/guide/huang.h"
#include "core/guide/ppg.h"
#include "core/guide/ppg_layout.h"

namespace qray {
namespace {

using Sections = std::span<const TableSection>;

struct Method {
  std::string_view name, table_method;
  std::unique_ptr<Guide> (*make)(const GuideSetup&);
  Result<GuideSetup> (*setup_of)(Sections);  // of its tables; null: it has none
};

template <class G>
std::unique_ptr<Guide> make(const GuideSetup& setup) {
  return std::make_unique<G>(setup);
}
template <HuangGuide::Density density>
std::unique_ptr<Guide> make_huang(const GuideSetup& setup) {
  return std::make_unique<HuangGuide>(density, setup.bounds, setup.huang, setup.max_bytes);
}
Result<GuideSetup> setup_of_huang(Sections s) { return setup_of_grid(s, kHuangLayout); }
Result<GuideSetup> setup_of_dahm_keller(Sections s) { return setup_of_grid(s, kDahmKellerLayout); }

constexpr Method kMethods[] = {
    {"none", "none", [](const GuideSetup&) { return std::unique_ptr<Guide>(); }, nullptr},
    {"huang-published", "huang", make_huang<HuangGuide::Density::kAsPublished>, setup_of_huang},
    {"huang", "huang", make_huang<HuangGuide::Density::kExact>, setup_of_huang},
    {"dahm-keller", "dahm-keller", make<DahmKellerGuide>, setup_of_dahm_keller},
    {"ppg", "ppg", make<PpgGuide>, setup_of_ppg},
    {"adaptive", "adaptive", make<AdaptiveGuide>, setup_of_adaptive},
};
constexpr auto kNames = [] {
  std::array<std::string_view, std::size(kMethods)> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kMethods[i].name;
  return names;
}();

const Method* find_method(std::string_view name) {
  const auto found = std::ranges::find(kMethods, name, &Method::name);
  return found == std::end(kMethods) ? nullptr : found;
}

}  // namespace

std::span<const std::string_view> method_names() { return kNames; }

std::string_view table_method(std::string_view method) {
  const Method* found = find_method(method);
  return found ? found->table_method : method;
}

Result<std::unique_ptr<Guide>> make_guide(std::string_view method, const GuideSetup& setup) {
  if (const Method* found = find_method(method)) return found->make(setup);
  std::string known;
  for (std::string_view name : kNames) known += (known.empty() ? "" : ", ") + std::string(name);
  return Error{ErrorCode::kInvalid,
               "unknown method '" + std::string(method) + "', expected one of " + known, "/method"};
}

Result<GuideSetup> setup_of_table(std::string_view method, std::span<const TableSection> sections) {
  if (const Method* found = find_method(method); found && found->setup_of)
    return found->setup_of(sections);
  return Error{ErrorCode::kUnsupported,
               "method '" + std::string(method) + "' has no tables in this program", "table"};
}

}  // namespace qray
