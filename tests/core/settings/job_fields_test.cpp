#include "core/settings/job_fields.h"

#include <gtest/gtest.h>

#include <set>

#include "core/guide/guide.h"

namespace qray {
namespace {

TEST(JobFields, EachIsThereOnceAndExplained) {
  for (const FieldTable* fields : {&job_fields(), &live_fields()}) {
    std::set<std::string> paths, options, keys;
    for (const Field& field : *fields) {
      EXPECT_TRUE(paths.insert(field.path).second) << field.path;
      EXPECT_TRUE(options.insert(field.option_name()).second) << field.path;
      const bool key_is_new =
          !(field.callers & kVariant) || keys.insert(field.variant_key()).second;
      EXPECT_TRUE(key_is_new) << field.path;
      EXPECT_TRUE(field.help.ends_with('.')) << field.path;
      EXPECT_NE(field.callers, 0u) << field.path;
    }
  }
}

TEST(JobFields, EveryMethodHasWordsForWhoChoosesIt) {
  const Field* method = find_field(job_fields(), "method");
  ASSERT_TRUE(method);
  ASSERT_EQ(method->choices.size(), method_names().size());
  for (size_t i = 0; i < method_names().size(); ++i) {
    EXPECT_EQ(method->choices[i].value, method_names()[i]);
    EXPECT_FALSE(method->choices[i].label.empty()) << method_names()[i];
  }
}

TEST(JobFields, DefaultsAreInRangeAndMethodsKnown) {
  const auto names = method_names();
  for (const Field& field : job_fields()) {
    for (const std::string& method : field.methods)
      EXPECT_NE(std::find(names.begin(), names.end(), method), names.end()) << field.path;
    EXPECT_EQ(field.group() == "guide", !field.methods.empty()) << field.path;
    if (!field.fallback) continue;
    double value = field.least;
    if (const auto* whole = std::get_if<int64_t>(&*field.fallback))
      value = static_cast<double>(*whole);
    if (const auto* number = std::get_if<double>(&*field.fallback)) value = *number;
    EXPECT_GE(value, field.least) << field.path;
    EXPECT_LE(value, field.most) << field.path;
  }
}

TEST(JobFields, SettingsAreJudgedByTheirRanges) {
  EXPECT_TRUE(check_settings(RenderSettings(), 1 << 20).ok());
  for (const Field& field : job_fields()) {
    if (!field.setting.read ||
        (field.type != FieldType::kWhole && field.type != FieldType::kNumber))
      continue;
    RenderSettings settings;
    if (field.path == "samples") settings.seconds = 1;
    const double beyond = field.most < 1e6 ? field.most + 1 : field.most * 2;
    field.setting.apply(settings, FieldValue(beyond));
    const Status status = check_settings(settings, int64_t{1} << 40);
    ASSERT_FALSE(status.ok()) << field.path;
    EXPECT_EQ(status.error().where, "/" + field.path);
  }
}

TEST(JobFields, ARegionLiesWithinThePicture) {
  RenderSettings settings;
  settings.width = 100, settings.height = 60;
  const auto where = [&](PixelRegion region) {
    settings.region = region;
    const Status status = check_settings(settings, 1 << 20);
    return status.ok() ? std::string() : status.error().where;
  };
  EXPECT_EQ(where({0, 0, 100, 60}), "");
  EXPECT_EQ(where({99, 59, 1, 1}), "");
  EXPECT_EQ(where({100, 0, 1, 1}), "/region/x");
  EXPECT_EQ(where({0, 60, 1, 1}), "/region/y");
  EXPECT_EQ(where({50, 0, 51, 1}), "/region/width");
  EXPECT_EQ(where({0, 30, 1, 31}), "/region/height");
  EXPECT_EQ(where({0, 30, 1, 0}), "/region/height");
  settings.pixels = Pixels::kByNoise;
  EXPECT_EQ(where({0, 0, 10, 10}), "/region");
}

TEST(JobFields, ReadsWhatIsTyped) {
  const auto value = [](const char* path, const char* text) {
    JobRequest request;
    EXPECT_TRUE(set_from_text(*find_field(job_fields(), path), text, kRender, request).ok())
        << text;
    return *request.find(path);
  };
  EXPECT_EQ(value("seed", "18446744073709551615"), FieldValue(UINT64_MAX));
  EXPECT_EQ(value("camera/position", "0,-1.5,1e2"), FieldValue(Vector3{0, -1.5, 100}));
  EXPECT_EQ(value("pixels", "quarter"), FieldValue("quarter"));
  EXPECT_EQ(value("recover", "weights.qrw"), FieldValue("weights.qrw"));
  const auto refused = [](const char* path, const char* text) {
    JobRequest request;
    const Status set = set_from_text(*find_field(job_fields(), path), text, kSubmit, request);
    EXPECT_FALSE(set.ok()) << path << " " << text;
    return set.ok() ? std::string() : set.error().message;
  };
  EXPECT_EQ(refused("samples", "many"), "expected a whole number, 1..1000000, got 'many'");
  EXPECT_EQ(refused("seed", "-1"), "expected a whole number, 0..18446744073709551615, got '-1'");
  EXPECT_EQ(refused("camera/up", "0,1"), "expected three numbers X,Y,Z, got '0,1'");
  EXPECT_EQ(refused("camera/up", "0,1,2,3"), "expected three numbers X,Y,Z, got '0,1,2,3'");
  EXPECT_EQ(refused("labels", "lobby"), "expected NAME:VALUE, got 'lobby'");
  JobRequest labels;
  for (const char* text : {"a:1", "b:x:y"})
    ASSERT_TRUE(set_from_text(*find_field(job_fields(), "labels"), text, kSubmit, labels).ok());
  EXPECT_EQ(labels.given(field::kLabels), (Labels{{"a", "1"}, {"b", "x:y"}}));
}

}  // namespace
}  // namespace qray
