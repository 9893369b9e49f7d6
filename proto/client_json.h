// What a client of the HTTP service writes and reads: docs/api.md is the contract. Fields that a
// newer server adds are passed over. Pure functions; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace qray::proto {

// POST /v1/scenes: files by name with their SHA-256, or one asset of a type.
struct SceneSubmission {
  std::map<std::string, std::string> files;
  std::string entry;  // empty: left to the server
  std::string asset, type;
};
std::string scene_submission_json(const SceneSubmission& submission);

// The part of a scene that the command shows.
struct SceneView {
  std::string name;
  std::vector<std::string> warnings;
};
Result<SceneView> parse_scene(std::string_view json);

// The part of a job that the command shows.
struct JobView {
  std::string id;
  std::string state;
  double fraction = 0;
  uint64_t samples = 0;  // a pixel
  double seconds = 0;
  std::string error;  // of a failed job: its place and message; else empty

  bool ended() const { return state == "succeeded" || state == "failed" || state == "canceled"; }
};
Result<JobView> parse_job(std::string_view json);

// Data of the server-sent events `state`, `loading`, `progress` and `done`: what it has of a job's
// fields.
struct JobHint {
  std::optional<std::string> state, step;
  std::optional<double> fraction, seconds;
  std::optional<uint64_t> samples;
};
Result<JobHint> parse_job_hint(std::string_view json);

// The text of an application/problem+json answer, its fields named; nullopt when it is none.
std::optional<std::string> problem_text(std::string_view json);

}  // namespace qray::proto
