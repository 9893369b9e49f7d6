// Checks the lines of an OBJ file before tinyobjloader sees them, which passes over most mistakes:
// numbers are numbers, indices exist, faces have three corners. Throws ImportFailure with the line.
#pragma once

#include <string>
#include <string_view>

namespace qray {

void check_obj_lines(std::string_view text, const std::string& file);

}  // namespace qray
