// Small JSON objects as text: for reports of the command. Field order is kept; NaN and infinities
// become null. Pure functions; any thread.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace qray::proto {

using JsonValue =
    std::variant<bool, int64_t, uint64_t, double, std::string, std::vector<std::string>,
                 std::vector<int>, std::map<std::string, std::string>>;
using JsonField = std::pair<std::string_view, JsonValue>;

// Indented by two spaces and ended by a newline, or on one line without.
std::string json_object(std::span<const JsonField> fields, bool indent = true);

// A number in an object; 0 where the text or the member is none.
double json_number(const std::string& object, const char* name);

}  // namespace qray::proto
