#include "core/guide/guide_table.h"

#include <string>

namespace qray {

Error cannot_merge(const GuideTable& into, const GuideTable& other) {
  if (other.method() != into.method())
    return {ErrorCode::kInvalid,
            "a table of method '" + std::string(other.method()) +
                "' cannot be merged into one of '" + std::string(into.method()) + "'",
            "table"};
  return {ErrorCode::kInvalid,
          "tables of method '" + std::string(into.method()) + "' cannot be merged", "table"};
}

}  // namespace qray
