#include "tests/support/contract.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "proto/openapi.h"
#include "tests/support/places.h"

namespace qray::test {
namespace {

using Json = nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;

constexpr const char* kMethods[] = {"get", "head", "post", "put", "delete", "patch"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::stringstream in(path);
  for (std::string part; std::getline(in, part, '/');) parts.push_back(part);
  if (path.ends_with('/')) parts.emplace_back();
  return parts;
}

// valijson reads numbers over INT64_MAX as negative, and asks a null for its format.
void suit_valijson(Json& node) {
  if (node.is_number_unsigned() && node.get<uint64_t>() > INT64_MAX) node = node.get<double>();
  if (node.is_object() && node.contains("format") && node["type"].is_array()) node.erase("format");
  if (node.is_structured()) {
    for (Json& child : node) suit_valijson(child);
  }
}

bool is_name(const std::string& part) { return part.starts_with('{') && part.ends_with('}'); }

bool matches(const std::string& pattern, const std::string& path) {
  const auto a = parts_of(pattern), b = parts_of(path);
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& p, const auto& q) { return is_name(p) || p == q; });
}

}  // namespace

struct Contract::Impl {
  Json document;

  const Json& resolved(const Json& node) const {
    if (!node.contains("$ref")) return node;
    return document.at(Json::json_pointer(node["$ref"].get<std::string>().substr(1)));
  }

  // Null: the contract has no such call. One without names in its path goes first.
  const Json* operation(const std::string& method, const std::string& path, bool& known) const {
    const Json* found = nullptr;
    known = false;
    for (const auto& [pattern, item] : document["paths"].items()) {
      if (!matches(pattern, path)) continue;
      known = true;
      const std::string listed = method == "head" && !item.contains("head") ? "get" : method;
      if (item.contains(listed) && (!found || pattern == path)) found = &item[listed];
    }
    return found;
  }

  std::string schema_fault(const Json& schema, const Json& value) const {
    const Json root = {{"allOf", {schema}}, {"components", document["components"]}};
    valijson::Schema compiled;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(Adapter(root), compiled);
    valijson::ValidationResults results;
    if (valijson::Validator().validate(compiled, Adapter(value), &results)) return "";
    std::string text = "against its schema:";
    for (const auto& error : results) {
      text += "\n  ";
      for (const std::string& step : error.context) text += step;
      text += ": " + error.description;
    }
    return text;
  }

  std::string content_fault(const Json& response, const Answer& answer) const {
    if (lower(answer.method) == "head") return "";
    if (!response.contains("content"))
      return answer.body.empty() ? "" : "a body where none is expected";
    const std::string type = answer.content_type.substr(0, answer.content_type.find(';'));
    const Json& content = response["content"];
    if (!content.contains(type)) return "Content-Type " + type + " is not listed";
    if (!type.ends_with("json")) return "";
    Json value = Json::parse(answer.body, nullptr, false);
    if (value.is_discarded()) return "not JSON";
    suit_valijson(value);
    return schema_fault(content[type]["schema"], value);
  }

  std::string fault(const Answer& answer) const {
    const std::string path = answer.target.substr(0, answer.target.find('?'));
    const std::string status = std::to_string(answer.status);
    bool known = false;
    const Json* call = operation(lower(answer.method), path, known);
    const Json& common = document["x-common-responses"];
    if (call && (*call)["responses"].contains(status))
      return content_fault(resolved((*call)["responses"][status]), answer);
    if (common.contains(status)) return content_fault(resolved(common[status]), answer);
    const Json problem = {{"$ref", "#/components/responses/Problem"}};
    if (!call && answer.status == (known ? 405 : 404))
      return content_fault(resolved(problem), answer);
    const bool found = answer.status == 200 || answer.status == 304;
    if (!known && found && !path.starts_with("/v1/")) return "";  // the page
    return call ? "a status that is not listed" : "a call that is not listed";
  }
};

Contract::Contract() {
  std::stringstream yaml;
  yaml << std::ifstream(test::source_dir() / "proto/openapi.yaml").rdbuf();
  const Result<std::string> json = proto::openapi_to_json(yaml.str());
  QRAY_CHECK(json.ok());
  Json document = Json::parse(json.value());
  suit_valijson(document);
  impl_ = std::make_shared<Impl>(Impl{std::move(document)});
}

const Contract& Contract::instance() {
  static const Contract contract;
  return contract;
}

std::string Contract::fault(const Answer& answer) const {
  const std::string fault = impl_->fault(answer);
  if (fault.empty()) return fault;
  return answer.method + " " + answer.target + " -> " + std::to_string(answer.status) + ": " +
         fault + "\n" + answer.body.substr(0, 2000);
}

std::map<std::string, std::string> Contract::calls() const {
  std::map<std::string, std::string> calls;
  for (const auto& [pattern, item] : impl_->document["paths"].items()) {
    for (std::string method : kMethods) {
      if (!item.contains(method)) continue;
      const std::string scope = item[method].value("x-scope", "");
      for (char& c : method) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      calls[method + " " + without_names(pattern)] = scope;
    }
  }
  return calls;
}

std::string without_names(const std::string& pattern) {
  std::string text;
  for (size_t i = 0; i < pattern.size(); ++i) {
    text += pattern[i];
    if (pattern[i] == '{') i = pattern.find('}', i) - 1;
  }
  return text;
}

}  // namespace qray::test
