#include "server/policy/table_choice.h"

namespace qray::server {
namespace {

constexpr size_t kMaxTablesTried = 8;

// Without a table: cold.
Result<StartingGuide> start_from(std::optional<TableFile> table, const PreparedScene& scene,
                                 const RenderSettings& settings) {
  Result<std::unique_ptr<Guide>> guide = load_guide(scene, settings, table);
  if (!guide.ok()) return guide.error();
  StartingGuide start{std::move(guide).value(), {}};
  if (table) start.table = std::move(table->header);
  return start;
}

Result<StartingGuide> start_from_best(TableStore& tables, const PreparedScene& scene,
                                      const RenderSettings& settings,
                                      const std::function<void(std::string)>& warn) {
  Result<std::vector<std::string>> ids =
      tables.fitting(table_method(settings.method), scene.hash, kMaxTablesTried);
  if (!ids.ok()) return ids.error();
  for (const std::string& id : ids.value()) {
    Result<TableFile> table = tables.load(id);
    if (!table.ok()) {
      warn("table " + id + " was not used: " + table.error().message);
      continue;
    }
    Result<StartingGuide> start = start_from(std::move(table).value(), scene, settings);
    if (start.ok()) return start;
    const Error& error = start.error();
    const bool passed_over =
        error.code == ErrorCode::kConflict || error.code == ErrorCode::kTooLarge;
    if (error.code != ErrorCode::kCorrupt && !passed_over) return start;
    warn("table " + id + " was not used: " + error.message);
    if (error.code == ErrorCode::kCorrupt) {
      if (Status s = tables.quarantine(id); !s.ok()) return s.error();
    }
  }
  return start_from(std::nullopt, scene, settings);
}

}  // namespace

Result<StartingGuide> choose_table(TableStore& tables, const PreparedScene& scene,
                                   const RenderSettings& settings, const TableWish& wish,
                                   const std::function<void(std::string)>& warn) {
  if (settings.method == "none" || wish.table == "none")
    return start_from(std::nullopt, scene, settings);
  if (wish.table == "auto") return start_from_best(tables, scene, settings, warn);
  Result<TableFile> table = tables.load(wish.table);
  if (!table.ok()) return table.error();
  if (wish.must_fit && !table_fits(table.value().header, scene.hash)) {
    return Error{ErrorCode::kConflict,
                 "table " + wish.table +
                     " was learned from another scene: expected the same geometry, "
                     "materials and lights",
                 "/table"};
  }
  return start_from(std::move(table).value(), scene, settings);
}

}  // namespace qray::server
