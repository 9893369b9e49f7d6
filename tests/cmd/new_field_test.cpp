// A field is added in one place: a row of the table of job fields. Everything made of the table has
// it then. A row of proto/openapi.yaml is all that is missing, which job_contract_test.cpp tells.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/cmd/render_options.h"
#include "core/settings/job_settings.h"
#include "core/settings/variant.h"
#include "proto/messages.h"

namespace qray {
namespace {

using Json = nlohmann::json;

FieldTable with(const Field& field) {
  FieldTable fields = job_fields();
  fields.push_back(field);
  return fields;
}

// The sharpness of a job, kept where the settings have room for a number.
FieldTable with_sharpness() {
  return with({.path = "sharpness",
               .type = FieldType::kNumber,
               .help = "How sharp the picture is.",
               .label = "Sharpness",
               .most = 4,
               .fallback = FieldValue(1.0),
               .callers = kJob | kRender | kSubmit | kVariant,
               .setting = {[](RenderSettings& s, const FieldValue& value) {
                 s.noise = std::get<double>(value);
               }}});
}

std::variant<JobRequest, proto::Problem> parse(const std::string& json, const FieldTable& fields) {
  return proto::parse_job_request(json, {}, fields);
}

TEST(NewField, RequestsHaveIt) {
  const FieldTable fields = with_sharpness();
  const auto parsed = parse(R"({"scene":"box","samples":1,"sharpness":2.5})", fields);
  ASSERT_TRUE(std::holds_alternative<JobRequest>(parsed));
  JobRequest request = std::get<JobRequest>(parsed);
  EXPECT_EQ(proto::job_request_to_json(request, fields),
            R"({"scene":"box","samples":1,"sharpness":2.5})");
  EXPECT_EQ(settings_of(request, Scene(), fields).noise, 2.5);
  request.clear("sharpness");
  fill_defaults(request, fields);
  EXPECT_EQ(*request.find("sharpness"), FieldValue(1.0));
  const auto wrong = parse(R"({"scene":"box","samples":1,"sharpness":5})", fields);
  ASSERT_TRUE(std::holds_alternative<proto::Problem>(wrong));
  EXPECT_EQ(std::get<proto::Problem>(wrong).detail, "/sharpness: expected a number, 0..4, got 5");
}

TEST(NewField, TheFormHasIt) {
  const Json form = Json::parse(proto::fields_to_json({}, with_sharpness()));
  EXPECT_EQ(form["fields"].back(), Json::parse(R"({"path":"sharpness","type":"number","unit":"",
      "label":"Sharpness","help":"How sharp the picture is.","minimum":0.0,"maximum":4.0,
      "default":1.0})"));
}

TEST(NewField, CommandsHaveIt) {
  const FieldTable fields = with_sharpness();
  for (const unsigned caller : {unsigned{kRender}, unsigned{kSubmit}}) {
    CLI::App app;
    cmd::RenderOptions options;
    cmd::add_render_options(app, options, caller, fields);
    EXPECT_NE(app.help().find("How sharp the picture is."), std::string::npos);
    app.parse("box --sharpness 3");
    const Result<JobRequest> request = cmd::make_request(options, caller, fields);
    ASSERT_TRUE(request.ok());
    EXPECT_EQ(*request.value().find("sharpness"), FieldValue(3.0));
    EXPECT_EQ(cmd::make_settings(options, Scene(), fields).value().noise, 3);
  }
}

TEST(NewField, VariantsHaveIt) {
  const FieldTable fields = with_sharpness();
  EXPECT_NE(variant_keys(fields).find("sharpness"), std::string::npos);
  EXPECT_EQ(*parse_variant("ppg:sharpness=2", kVariant, fields).value().find("sharpness"),
            FieldValue(2.0));
}

TEST(NewField, ASettingOfAGuideIsItsMethodsAlone) {
  const FieldTable fields = with({.path = "guide/lobes",
                                  .help = "How many lobes a place has.",
                                  .least = 1,
                                  .most = 8,
                                  .callers = kJob | kSubmit | kVariant,
                                  .methods = {"ppg"}});
  const auto ppg = parse(R"({"scene":"box","method":"ppg","guide":{"lobes":3}})", fields);
  ASSERT_TRUE(std::holds_alternative<JobRequest>(ppg));
  EXPECT_EQ(*std::get<JobRequest>(ppg).find("guide/lobes"), FieldValue(int64_t{3}));
  const auto huang = parse(R"({"scene":"box","method":"huang","guide":{"lobes":3}})", fields);
  ASSERT_TRUE(std::holds_alternative<proto::Problem>(huang));
  EXPECT_EQ(std::get<proto::Problem>(huang).detail,
            "/guide/lobes: the method huang has no such setting: it belongs to ppg");
  EXPECT_TRUE(parse_variant("ppg:lobes=3", kSubmit, fields).ok());
  EXPECT_FALSE(parse_variant("huang:lobes=3", kSubmit, fields).ok());
  EXPECT_EQ(Json::parse(proto::fields_to_json({}, fields))["fields"].back()["methods"],
            Json::array({"ppg"}));
}

}  // namespace
}  // namespace qray
