// Parameters of Mitsuba plugins: numbers, points, flags and transforms of a MitsubaNode. Throws
// ImportFailure naming the parameter's line. Any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/import/mitsuba_tree.h"
#include "core/scene/transform.h"

namespace qray {

// Numbers between commas, spaces or both.
std::vector<double> parse_numbers(const MitsubaNode& node, const std::string& text);
double parse_number(const MitsubaNode& node, const std::string& text);

// The child with this name (in snake_case) and any tag; null: without. A name given twice counts
// as it stands first.
const MitsubaNode* find_parameter(const MitsubaNode& plugin, std::string_view name);

std::optional<double> find_number(const MitsubaNode& plugin, std::string_view name);
std::optional<bool> find_flag(const MitsubaNode& plugin, std::string_view name);
std::optional<Vec3> find_point(const MitsubaNode& plugin, std::string_view name);
const std::string* find_text(const MitsubaNode& plugin, std::string_view name);

// The map that a <transform> makes, its steps in their order; none: the plugin has none of the
// name. Fails where it cannot be undone.
std::optional<Transform> find_transform(const MitsubaNode& plugin, std::string_view name);

}  // namespace qray
