#include "proto/json_text.h"

#include <nlohmann/json.hpp>

namespace qray::proto {

std::string json_object(std::span<const JsonField> fields, bool indent) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const auto& [name, value] : fields)
    std::visit([&, key = std::string(name)](const auto& v) { object[key] = v; }, value);
  const auto replace = nlohmann::ordered_json::error_handler_t::replace;  // bytes that are no UTF-8
  return indent ? object.dump(2, ' ', false, replace) + "\n" : object.dump(-1, ' ', false, replace);
}

double json_number(const std::string& object, const char* name) {
  const nlohmann::json parsed = nlohmann::json::parse(object, nullptr, false);
  const auto found = parsed.find(name);
  return found != parsed.end() && found->is_number() ? found->get<double>() : 0;
}

}  // namespace qray::proto
