// A row of the table of job fields, and what can be asked of such a table. Immutable; any thread.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/settings/job_request.h"
#include "core/settings/render_settings.h"

namespace qray {

enum class FieldType {
  kSwitch,   // bool
  kWhole,    // int64_t
  kWhole64,  // uint64_t: every one of 64 bits
  kNumber,   // double
  kChoice,   // std::string, one of `choices`, or `other`; anything where there are no choices
  kName,     // std::string: 1..64 of a-z, 0-9 and -
  kText,     // std::string of at most kMaxText bytes
  kVector,   // Vector3
  kLabels,   // Labels
  kCameras,  // Cameras
  kNames,    // Names: each one of `choices`
};

// Who may give a field; bits of Field::callers. The page asks for those of kJob that have a label.
enum Caller : unsigned {
  kJob = 1,      // POST /v1/jobs
  kLive = 2,     // POST /v1/live
  kRender = 4,   // an option of `qray render`
  kSubmit = 8,   // an option of `qray submit`
  kVariant = 16  // a key of a method's variant: "huang:grid=12"
};

struct Choice {
  std::string value;
  std::string label = {};  // the page's; empty: the value
  unsigned callers = ~0u;
};

// How a field stands in RenderSettings; both empty: the renderer does not know it.
struct SettingOfField {
  std::function<void(RenderSettings&, const FieldValue&)> apply = {};
  // Nothing: the settings say that it was not asked for, such as 0 seconds.
  std::function<std::optional<FieldValue>(const RenderSettings&)> read = {};
};

struct Field {
  std::string path;  // "samples"; a group's member: "guide/alpha"
  FieldType type = FieldType::kWhole;
  bool required = false;
  std::string help = {};       // a sentence, for every caller
  std::string label = {};      // the page's; empty: the page does not ask for it
  std::string unit = {};       // "pixels", "s"
  double least = 0, most = 0;  // of kWhole and kNumber
  bool above_least = false;    // `least` itself is not allowed
  int multiple_of = 1;         // of kWhole
  std::string zero = {};       // of kWhole: a word that means 0, which is not in its range
  std::vector<Choice> choices = {};
  std::string other = {};  // what a kChoice may be beside: "the id of a table (32 hex digits)"
  std::optional<FieldValue> fallback = {};  // none: the scene's, or left open
  unsigned callers = 0;
  std::vector<std::string> methods = {};  // that have the setting; empty: it is every job's
  std::string option = {};                // the command's, "--spp"; empty: made of the name
  std::string key = {};                   // a variant's, "learning"; empty: made of the name
  SettingOfField setting = {};

  std::string_view group() const;  // "guide"; empty: none
  std::string_view name() const;   // "alpha"
  std::string option_name() const;
  std::string variant_key() const;
  bool of_method(std::string_view method) const;
};

constexpr size_t kMaxText = 4096;  // bytes

using FieldTable = std::vector<Field>;

// Null: there is none.
const Field* find_field(const FieldTable& fields, std::string_view path);

// "a whole number, 1..64": what a caller is told to give.
std::string expected(const Field& field, unsigned caller);
std::string number_text(double value);  // "0.001"
// Why the method cannot have the field, and which can.
std::string not_of_method(const Field& field, std::string_view method);

// Gives the request what was typed, an option's value or a variant's. It is of the field's type and
// one of its choices, but maybe out of its range: check_settings() or the server judge that. Labels
// are "name:value", each added to those before; so is each camera.
Status set_from_text(const Field& field, std::string_view text, unsigned caller,
                     JobRequest& request);

// A float as the number of the fewest digits that mean it: 0.2, not 0.200000003.
double short_double(float value);

}  // namespace qray
