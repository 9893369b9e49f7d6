#include "proto/openapi.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

namespace qray::proto {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string line_of(const YAML::Mark& mark) { return std::to_string(mark.line + 1); }

template <class T>
std::optional<T> number(std::string_view text, int base = 10) {
  T value{};
  std::from_chars_result read{};
  const char* end = text.data() + text.size();
  if constexpr (std::is_integral_v<T>) {
    read = std::from_chars(text.data(), end, value, base);
  } else {
    read = std::from_chars(text.data(), end, value);
  }
  if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return value;
}

bool one_of(std::string_view text, std::initializer_list<std::string_view> forms) {
  return std::find(forms.begin(), forms.end(), text) != forms.end();
}

// Of a scalar without quotes.
OrderedJson typed(std::string_view text, const YAML::Mark& mark) {
  if (one_of(text, {"", "~", "null", "Null", "NULL"})) return nullptr;
  if (one_of(text, {"true", "True", "TRUE"})) return true;
  if (one_of(text, {"false", "False", "FALSE"})) return false;
  if (text.starts_with("0x")) {
    if (const auto v = number<uint64_t>(text.substr(2), 16)) return *v;
  }
  if (text.starts_with("0o")) {
    if (const auto v = number<uint64_t>(text.substr(2), 8)) return *v;
  }
  std::string_view unsigned_text = text;
  if (text.starts_with('+') || text.starts_with('-')) unsigned_text.remove_prefix(1);
  const bool numeric = !unsigned_text.empty() &&
                       unsigned_text.find_first_not_of("0123456789.eE+-") == std::string_view::npos;
  if (one_of(unsigned_text, {".inf", ".Inf", ".INF", ".nan", ".NaN", ".NAN"}))
    throw YAML::Exception(mark, "JSON has no infinities and no NaN");
  if (!numeric) return std::string(text);
  const std::string_view plain = text.starts_with('+') ? unsigned_text : text;
  if (const auto v = number<int64_t>(plain)) return *v;
  if (const auto v = number<uint64_t>(plain)) return *v;
  if (const auto v = number<double>(plain)) return *v;
  return std::string(text);
}

OrderedJson json_of(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Undefined:
    case YAML::NodeType::Null:
      return nullptr;
    case YAML::NodeType::Scalar:
      return node.Tag() == "!" ? OrderedJson(node.Scalar()) : typed(node.Scalar(), node.Mark());
    case YAML::NodeType::Sequence: {
      OrderedJson list = OrderedJson::array();
      for (const YAML::Node& item : node) list.push_back(json_of(item));
      return list;
    }
    case YAML::NodeType::Map:
      break;
  }
  OrderedJson object = OrderedJson::object();
  for (const auto& member : node) {
    const std::string& name = member.first.Scalar();
    if (object.contains(name)) throw YAML::Exception(member.first.Mark(), "a name twice: " + name);
    object[name] = json_of(member.second);
  }
  return object;
}

}  // namespace

Result<std::string> openapi_to_json(std::string_view yaml) {
  try {
    return json_of(YAML::Load(std::string(yaml))).dump();
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kInvalid, e.msg, "openapi.yaml:" + line_of(e.mark)};
  } catch (const OrderedJson::exception&) {
    return Error{ErrorCode::kInvalid, "expected UTF-8", "openapi.yaml"};
  }
}

std::map<std::string, std::set<std::string>> query_parameters(const std::string& openapi_json) {
  std::map<std::string, std::set<std::string>> names;
  const auto contract = nlohmann::json::parse(openapi_json);
  const auto add = [&](const nlohmann::json& of, std::set<std::string>& to) {
    for (const auto& entry : of.value("parameters", nlohmann::json::array())) {
      const bool elsewhere = entry.contains("$ref");  // "#/components/parameters/X"
      const auto& parameter = elsewhere ? contract.at(nlohmann::json::json_pointer(
                                              entry["$ref"].get<std::string>().substr(1)))
                                        : entry;
      if (parameter.at("in") == "query") to.insert(parameter.at("name"));
    }
  };
  for (const auto& [path, operations] : contract.at("paths").items()) {
    for (const auto& [method, operation] : operations.items()) {
      if (method == "parameters") continue;
      std::string key = method;
      for (char& c : key) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      std::set<std::string>& of_operation = names[key + " " + path];
      add(operations, of_operation);
      add(operation, of_operation);
    }
  }
  return names;
}

}  // namespace qray::proto
