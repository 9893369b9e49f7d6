// Indices of refraction by the names that Mitsuba gives them. Pure functions.
#pragma once

#include <optional>
#include <string_view>

#include "core/math/vec.h"

namespace qray {

// Of a clear material: "bk7", "air".
std::optional<float> find_ior(std::string_view name);

struct ComplexIor {
  Rgb eta, k;
};
// Of a metal or crystal: "Cu", "Al", with or without "_palik".
std::optional<ComplexIor> find_complex_ior(std::string_view name);

}  // namespace qray
