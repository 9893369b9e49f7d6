#include "server/api/references.h"

#include "core/recover/included_networks.h"

namespace qray::server {

void check_scene(const Stores& stores, const std::string& scene, std::optional<int>& width,
                 std::optional<int>& height, int64_t max_pixels,
                 std::vector<proto::FieldError>& errors) {
  if (!stores.scenes.has(scene)) {
    errors.push_back({"/scene", "no scene of this name: see /v1/scenes"});
  } else if (!width || !height) {
    if (const auto size = stores.scenes.size(scene)) {
      if (!width) width = size->first;
      if (!height) height = size->second;
    }
  }
  // The size that a request gives itself was looked at before, that of its scene was not.
  const int64_t pixels = int64_t{width.value_or(1)} * height.value_or(1);
  if (pixels > max_pixels)
    errors.push_back({"/width", "expected at most " + std::to_string(max_pixels) +
                                    " pixels in all, got " + std::to_string(pixels)});
}

void check_table(const Stores& stores, const std::string& table, const std::string& method,
                 std::vector<proto::FieldError>& errors) {
  if (table == "auto" || table == "none") return;
  const Result<proto::TableInfo> found = stores.tables.find(table);
  if (!found.ok()) {
    errors.push_back({"/table", "no table with this id: see /v1/tables"});
  } else if (found.value().method != table_method(method)) {
    errors.push_back(
        {"/table", "a table of method " + found.value().method + " does not serve " + method});
  }
}

void check_recover(const Stores& stores, const std::string& recover,
                   std::vector<proto::FieldError>& errors) {
  const bool own = !included_network(recover).ok() && recover != "auto" && recover != "none";
  if (own && !stores.weights.find(recover).ok())
    errors.push_back({"/recover", "no weights with this id: see /v1/weights"});
}

std::optional<proto::Problem> problem_of(std::vector<proto::FieldError> errors, std::string title) {
  if (errors.empty()) return std::nullopt;
  proto::Problem problem{422, std::move(title), "", std::move(errors)};
  problem.detail = problem.errors.front().pointer + ": " + problem.errors.front().detail;
  return problem;
}

}  // namespace qray::server
