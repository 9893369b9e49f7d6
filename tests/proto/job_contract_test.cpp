// What proto/openapi.yaml says of requests of jobs and of live sessions, against the table of
// fields that reads them: names, types, ranges, defaults and what may be chosen.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/guide/guide.h"
#include "core/settings/frames.h"
#include "proto/camera_json.h"
#include "proto/messages.h"
#include "proto/openapi.h"
#include "tests/support/places.h"

namespace qray::proto {
namespace {

using Json = nlohmann::json;

class Contract {
 public:
  Contract() {
    std::stringstream yaml;
    yaml << std::ifstream(test::source_dir() / "proto/openapi.yaml").rdbuf();
    document_ = Json::parse(openapi_to_json(yaml.str()).value());
  }

  // The schema that a path means within a request; null: none. References are followed, and what
  // stands beside one counts too.
  Json schema(const char* request, const Field& field) const {
    const Json& top = document_["components"]["schemas"][request]["properties"];
    if (field.group().empty()) return member(top, field.name());
    const Json group = member(top, field.group());
    return group.is_null() ? group : member(group["properties"], field.name());
  }
  std::set<std::string> paths(const char* request) const {
    std::set<std::string> out;
    for (const auto& [name, schema] :
         document_["components"]["schemas"][request]["properties"].items()) {
      const Json whole = resolved(schema);
      if (!whole.contains("properties")) out.insert(name);
      if (whole.contains("properties"))
        for (const auto& [inner, unused] : whole["properties"].items())
          out.insert(name + "/" + inner);
    }
    return out;
  }
  Json resolved(Json schema) const {
    if (!schema.contains("$ref")) return schema;
    Json out =
        resolved(document_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))));
    schema.erase("$ref");
    out.update(schema);
    return out;
  }

 private:
  Json member(const Json& properties, std::string_view name) const {
    const auto found = properties.find(std::string(name));
    return found == properties.end() ? Json() : resolved(*found);
  }
  Json document_;
};

double most_allowed(const Field& field) {
  return field.path == "seconds" ? RequestLimits().max_seconds : field.most;
}

void expect_range(const Json& whole, const Field& field) {
  const Json& schema = field.zero.empty() ? whole : whole["anyOf"][0];
  if (!field.zero.empty()) {
    EXPECT_EQ(whole["anyOf"][1]["enum"], Json::array({field.zero})) << field.path;
  }
  EXPECT_EQ(schema["type"], field.type == FieldType::kWhole ? "integer" : "number") << field.path;
  EXPECT_EQ(schema[field.above_least ? "exclusiveMinimum" : "minimum"], field.least) << field.path;
  EXPECT_EQ(schema["maximum"], most_allowed(field)) << field.path;
  EXPECT_EQ(schema.value("multipleOf", 1), field.multiple_of) << field.path;
}

// {enum: [...]}, or anyOf: such a one and a reference to ids.
void expect_choices(const Json& schema, const Field& field, unsigned caller) {
  EXPECT_EQ(schema.contains("anyOf"), !field.other.empty()) << field.path;
  const Json& listed = schema.contains("anyOf") ? schema["anyOf"][0]["enum"] : schema["enum"];
  std::vector<std::string> choices;
  for (const Choice& choice : field.choices)
    if (choice.callers & caller) choices.push_back(choice.value);
  EXPECT_EQ(listed, Json(choices)) << field.path;
}

void expect_same(const Json& schema, const Field& field, unsigned caller) {
  switch (field.type) {
    case FieldType::kSwitch:
      EXPECT_EQ(schema["type"], "boolean") << field.path;
      break;
    case FieldType::kWhole:
    case FieldType::kNumber:
      expect_range(schema, field);
      break;
    case FieldType::kWhole64:
      EXPECT_EQ(schema["maximum"], UINT64_MAX) << field.path;
      break;
    case FieldType::kChoice:
      expect_choices(schema, field, caller);
      break;
    case FieldType::kName:
      EXPECT_EQ(schema["pattern"], "^[a-z0-9-]{1,64}$") << field.path;
      break;
    case FieldType::kVector:
      EXPECT_EQ(schema["items"]["maximum"], field.most) << field.path;
      break;
    case FieldType::kCameras:
      EXPECT_EQ(schema["maxItems"], kMaxFrames) << field.path;
      break;
    case FieldType::kText:
      EXPECT_EQ(schema["maxLength"], kMaxText) << field.path;
      break;
    case FieldType::kNames:
      expect_choices(schema["items"], field, caller);
      break;
    case FieldType::kLabels:
      EXPECT_EQ(schema["maxProperties"], kMaxLabels) << field.path;
      break;
  }
  Json fallback;
  if (field.fallback) std::visit([&](const auto& value) { fallback = value; }, *field.fallback);
  EXPECT_EQ(schema.value("default", Json()), fallback) << field.path;
  EXPECT_EQ(schema.value("x-methods", std::vector<std::string>()), field.methods) << field.path;
}

void compare(const char* request, const FieldTable& fields, unsigned caller) {
  const Contract contract;
  std::set<std::string> paths;
  for (const Field& field : fields) {
    if (!(field.callers & caller)) continue;
    paths.insert(field.path);
    const Json schema = contract.schema(request, field);
    ASSERT_FALSE(schema.is_null()) << field.path << " is not in the contract's " << request;
    expect_same(schema, field, caller);
  }
  EXPECT_EQ(contract.paths(request), paths);
}

TEST(JobContract, SaysWhatTheTableSays) { compare("JobRequest", job_fields(), kJob); }

TEST(JobContract, OfLiveSessionsToo) { compare("LiveRequest", live_fields(), kLive); }

TEST(JobContract, ApiPageNamesEveryField) {
  std::stringstream page;
  page << std::ifstream(test::source_dir() / "docs/api.md").rdbuf();
  const std::string text = page.str();
  for (const Field& field : job_fields()) {
    if (!(field.callers & kJob)) continue;
    const std::string row = "| `" + field.path + "` | " + field.help + " |";
    EXPECT_NE(text.find(row), std::string::npos) << "docs/api.md has no row " << row;
  }
}

}  // namespace
}  // namespace qray::proto
