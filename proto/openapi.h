// openapi.yaml, the contract, as the JSON of GET /openapi.json. Plain scalars get the types of
// YAML's core schema (YAML 1.2.2, section 10.3.2); quoted ones stay text. Pure function.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace qray::proto {

// kInvalid names the line: not YAML, a name twice, or a number that JSON does not have.
Result<std::string> openapi_to_json(std::string_view yaml);

// What queries may name, by operation ("GET /v1/jobs"), of that JSON.
std::map<std::string, std::set<std::string>> query_parameters(const std::string& openapi_json);

}  // namespace qray::proto
