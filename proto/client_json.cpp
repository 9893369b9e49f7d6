#include "proto/client_json.h"

#include <nlohmann/json.hpp>

namespace qray::proto {
namespace {

using nlohmann::json;

// The server's text is bounded by the client's limit on a body, and not nested by its contract; a
// hostile one is refused before the parser can recurse.
bool nested_too_deeply(std::string_view text) {
  int depth = 0;
  for (char c : text) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > 64) return true;
  }
  return false;
}

std::optional<json> parse_object(std::string_view text) {
  if (nested_too_deeply(text)) return std::nullopt;
  json value = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!value.is_object()) return std::nullopt;
  return value;
}

const json* find(const json& object, const char* name) {
  const auto it = object.find(name);
  return it == object.end() || it->is_null() ? nullptr : &*it;
}
std::optional<std::string> text_of(const json& object, const char* name) {
  const json* value = find(object, name);
  return value && value->is_string() ? std::optional(value->get<std::string>()) : std::nullopt;
}
std::optional<double> number_of(const json& object, const char* name) {
  const json* value = find(object, name);
  return value && value->is_number() ? std::optional(value->get<double>()) : std::nullopt;
}
std::optional<uint64_t> count_of(const json& object, const char* name) {
  const json* value = find(object, name);
  return value && value->is_number_unsigned() ? std::optional(value->get<uint64_t>())
                                              : std::nullopt;
}

JobHint hint_of(const json& object) {
  return {text_of(object, "state"), text_of(object, "step"), number_of(object, "fraction"),
          number_of(object, "seconds"), count_of(object, "samples")};
}

}  // namespace

std::string scene_submission_json(const SceneSubmission& s) {
  json object = json::object();
  if (!s.files.empty()) object["files"] = s.files;
  if (!s.entry.empty()) object["entry"] = s.entry;
  if (!s.asset.empty()) object["asset"] = s.asset;
  if (!s.type.empty()) object["type"] = s.type;
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

Result<SceneView> parse_scene(std::string_view text) {
  const std::optional<json> object = parse_object(text);
  const std::optional<std::string> name = object ? text_of(*object, "name") : std::nullopt;
  if (!name) return Error{ErrorCode::kCorrupt, "the server's answer is not a scene", ""};
  SceneView scene{*name, {}};
  if (const json* warnings = find(*object, "warnings"); warnings && warnings->is_array())
    for (const json& warning : *warnings)
      if (warning.is_string()) scene.warnings.push_back(warning.get<std::string>());
  return scene;
}

Result<JobView> parse_job(std::string_view text) {
  const std::optional<json> object = parse_object(text);
  if (!object) return Error{ErrorCode::kInvalid, "expected a job as JSON", "the server's answer"};
  const std::optional<std::string> id = text_of(*object, "id"), state = text_of(*object, "state");
  if (!id || !state)
    return Error{ErrorCode::kInvalid, "expected a job with id and state", "the server's answer"};
  JobView job;
  job.id = *id;
  job.state = *state;
  if (const json* progress = find(*object, "progress"); progress && progress->is_object()) {
    const JobHint hint = hint_of(*progress);
    job.fraction = hint.fraction.value_or(0);
    job.samples = hint.samples.value_or(0);
    job.seconds = hint.seconds.value_or(0);
  }
  if (const json* error = find(*object, "error"); error && error->is_object()) {
    const std::string where = text_of(*error, "where").value_or("");
    job.error = (where.empty() ? "" : where + ": ") + text_of(*error, "message").value_or("");
  }
  return job;
}

Result<JobHint> parse_job_hint(std::string_view text) {
  const std::optional<json> object = parse_object(text);
  if (!object) return Error{ErrorCode::kInvalid, "expected an event's JSON object", ""};
  return hint_of(*object);
}

std::optional<std::string> problem_text(std::string_view text) {
  const std::optional<json> object = parse_object(text);
  if (!object || !object->contains("title")) return std::nullopt;
  std::string out = text_of(*object, "title").value_or("");
  if (const auto detail = text_of(*object, "detail")) out += ": " + *detail;
  if (const json* errors = find(*object, "errors"); errors && errors->is_array())
    for (const json& error : *errors)
      if (error.is_object())
        out += "\n  " + text_of(error, "pointer").value_or("") + ": " +
               text_of(error, "detail").value_or("");
  return out;
}

}  // namespace qray::proto
