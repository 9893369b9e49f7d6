// Checks the lines of an OBJ file before tinyobjloader sees them, which passes over most mistakes:
// numbers are numbers, indices exist, faces have three corners. Throws ImportFailure with the line.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace qray {

// `told`: now and then, the share that was checked.
void check_obj_lines(std::string_view text, const std::string& file,
                     const std::function<void(double)>& told);

}  // namespace qray
