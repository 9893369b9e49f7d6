// What crosses the wire as JSON, as plain std types: job requests, jobs, tables, scenes, problems.
// docs/api.md and openapi.yaml are the contract. Any thread; nothing here throws on bad input.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/settings/job_fields.h"

namespace qray::proto {

struct FieldError {
  std::string pointer;  // RFC 6901: "/camera/position/1"; empty: the whole document
  std::string detail;   // what was expected, what came
};

// RFC 9457. `detail` and `errors` never hold an exception's text.
struct Problem {
  int status = 500;
  std::string title;
  std::string detail;
  std::vector<FieldError> errors;
};

// Of scenes and labels: 1..64 of a-z, 0-9 and -.
bool is_name(std::string_view text);
// Of tables and weights.
inline bool is_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

constexpr size_t kMaxLabels = 16, kMaxLabelValue = 256;  // bytes

// POST /v1/jobs/{id}/extend: how much more, and until how little noise.
struct ExtendRequest {
  std::optional<int> samples;
  std::optional<double> seconds;  // one of the two after parsing
  std::optional<double> noise;
};

// PATCH /v1/jobs/{id}: what is given takes the place of what was.
struct JobUpdate {
  std::optional<Labels> labels;
  std::optional<int> priority;
};

// POST /v1/scenes: what a scene is made of, by the SHA-256 of uploaded files.
struct SceneRequest {
  std::map<std::string, std::string> files;  // name -> SHA-256; empty: `archive` has them
  std::string archive;                       // a zip's SHA-256
  std::string entry;                         // the scene's file; empty: to be found
  std::string title;                         // what people call it; empty: its name
};

// What a server allows, beside the ranges of the table of fields: the narrower of the two rules.
struct RequestLimits {
  size_t max_bytes = 4u << 20;
  int max_nesting = 32;
  int64_t max_pixels = 4096LL * 4096;
  double max_seconds = 3600;
};

// {"position":[0,1,2],...}: a camera by itself, as a job's "camera" has it.
std::variant<CameraRequest, Problem> parse_camera(std::string_view json);
// {"turntable":36}: what a job's "frames" holds, with the fields' paths.
std::variant<JobRequest, Problem> parse_frames(std::string_view json);

// 400: not JSON; 413: too large; 422: every field that is wrong, by pointer.
// A job's: one of samples and seconds is given afterwards, other defaults are left out still.
std::variant<JobRequest, Problem> parse_job_request(std::string_view json,
                                                    const RequestLimits& limits,
                                                    const FieldTable& fields = job_fields());
// What a server accepted once, this version or an older one, whatever its limits were: its method
// and its times may be any, and settings of a guide may stand beside the method (until 0.1 they
// did; those that the method does not have are dropped).
std::variant<JobRequest, Problem> parse_stored_request(std::string_view json);
std::variant<ExtendRequest, Problem> parse_extend_request(std::string_view json,
                                                          const RequestLimits& limits);
std::variant<JobUpdate, Problem> parse_job_update(std::string_view json,
                                                  const RequestLimits& limits);
// {"tables":[id, id...]}: two ids or more, at most `kMaxMergedTables`, each once. Problems as
// above.
constexpr size_t kMaxMergedTables = 16;
std::variant<std::vector<std::string>, Problem> parse_merge_request(std::string_view json,
                                                                    const RequestLimits& limits);
// {"token":"..."}: the token. Problems as above.
std::variant<std::string, Problem> parse_session_request(std::string_view json,
                                                         const RequestLimits& limits);
// {"url":"..."}: the url, of which only its type was checked. Problems as above.
std::variant<std::string, Problem> parse_webhook_request(std::string_view json,
                                                         const RequestLimits& limits);
// Problems as above. A file's name is one that FileNames takes.
std::variant<SceneRequest, Problem> parse_scene_request(std::string_view json,
                                                        const RequestLimits& limits);
// The same text for the same scene, whatever the order it was given in.
std::string scene_manifest(const SceneRequest& request);
// PATCH /v1/scenes/{name}: the new title.
std::variant<std::string, Problem> parse_title_request(std::string_view json,
                                                       const RequestLimits& limits);
// "/files/textures~1a.png"
std::string file_pointer(std::string_view name);
// Gives the same request back when parsed: what was given, in the table's order.
std::string job_request_to_json(const JobRequest& request, const FieldTable& fields = job_fields());
std::string extend_request_to_json(const ExtendRequest& request);
// GET /v1/fields: what a job may be told, as a form needs it.
std::string fields_to_json(const RequestLimits& limits, const FieldTable& fields = job_fields());

struct JobProgress {
  double fraction = 0;   // of the job, [0, 1]
  uint64_t samples = 0;  // a pixel, in complete passes
  double seconds = 0;
};

// GET /v1/jobs/{id}/frames: one of them.
struct FrameInfo {
  int frame = 0;
  std::string camera;  // the scene's own; empty: another
  std::string state;   // waiting, rendering, done
  double fraction = 0;
  uint64_t samples = 0;           // a pixel
  double seconds = 0, noise = 0;  // 0: not known
  std::string stats_json;         // an object's text; empty: none yet
};

struct JobError {
  std::string message, where;
  std::string text() const { return where.empty() ? message : where + ": " + message; }
};

struct JobInfo {
  std::string id, state;
  JobRequest request;
  int64_t created_ms = 0;  // since 1970-01-01 UTC, as all times here
  std::optional<int64_t> started_ms, ended_ms;
  JobProgress progress;
  std::optional<JobError> error;
  std::string table_in, table_out;  // empty: none
  std::string stats_json;           // an object's text; empty: none yet
  bool biased = false;
  std::vector<std::string> warnings;
  bool extendable = false;  // more can be rendered onto it
};

struct TableInfo {
  std::string id, scene, method;
  std::vector<std::string> parents;
  int64_t created_ms = 0;
  uint64_t bytes = 0, states = 0, samples_seen = 0;
  std::string job;  // that left it; empty: it was merged
};

struct WebhookInfo {
  std::string id, url;
  int64_t created_ms = 0;
  uint64_t failures = 0, waiting = 0;
};

struct WeightsInfo {
  std::string id, scene, program;
  int64_t created_ms = 0;
  uint64_t bytes = 0, steps = 0, views = 0;
  std::optional<double> held_out;  // mean relMSE of the views kept apart
};

struct SceneInfo {
  std::string name;
  std::optional<int> width, height;  // absent: the scene cannot be loaded
  bool uploaded = false;
  std::string title{};                 // what people call it; empty: its name
  std::vector<std::string> cameras{};  // that it names
};

// What the process that reads an upload found: a scene, or why it is none. Kept with the scene.
struct SceneReport {
  std::optional<JobError> error;
  std::string entry;  // the scene's file among the others
  int width = 0, height = 0;
  uint64_t triangles = 0;
  uint64_t unpacked_bytes = 0;  // that an archive's files take
  std::vector<std::string> warnings;
  std::string title{};  // of the scene; empty: its name
  std::vector<std::string> cameras{};
};

// Of a picture from its reference: core/image/metrics.h says what each is.
struct PictureDifference {
  double relmse = 0, relmse_trimmed = 0, flip = 0, mean_ratio = 0, max_abs = 0;
};

// GET /v1/jobs/{id}/metrics: what was known after a pass.
struct Moment {
  uint32_t number = 0;            // of the pass, from 1
  uint64_t samples = 0;           // a pixel, so far
  double seconds = 0, noise = 0;  // noise: 0: not known
  bool learning = false, guided = false;
  double efficiency_gain = 0;  // 0: not known
  uint64_t states = 0, direction_nodes = 0, table_bytes = 0;
  std::string gate;                     // "on", or "off: " and why; empty: no guide
  bool picture = false, table = false;  // that of the moment is kept
};

struct JobMetrics {
  std::string job, ref;  // `ref` may be empty
  std::vector<Moment> moments;
  std::map<uint32_t, double> relmse;  // from ref, by the moments' numbers
};

// GET /v1/jobs/{id}/pixel.
struct PixelDirection {
  std::array<float, 3> wi{};
  float pdf_w = 0;
  std::optional<std::array<float, 2>> screen;  // where a rod along it ends, in pixels
};
struct DirectionSquare {
  float u = 0, v = 0, size = 0, pdf_w = 0;
};
struct PixelState {
  uint64_t id = 0;
  std::string color;  // of view=state, "#rrggbb"
  bool known = false;
  std::optional<double> size_m;
  std::optional<uint64_t> visits;
  double gain = 1, guide_fraction = 0;
  std::vector<PixelDirection> directions;
  std::vector<DirectionSquare> cells;  // empty: the method has none
};
struct PixelInfo {
  int x = 0, y = 0;
  std::array<float, 3> radiance{};
  uint64_t samples = 0;
  std::optional<double> variance, standard_error;  // of luminance: a sample's; the mean's
  std::optional<std::pair<std::array<float, 3>, std::array<float, 3>>> surface;  // position, normal
  std::optional<PixelState> state;
};

// GET /v1/compare.
struct Comparison {
  std::string a, b, ref;                              // jobs; `ref` may be empty
  PictureDifference difference;                       // of a from b
  std::optional<PictureDifference> a_error, b_error;  // from ref
};

std::string frames_to_json(std::string_view job, std::span<const FrameInfo> frames);
// Back from such a text; empty: it is none.
std::vector<FrameInfo> parse_frame_infos(std::string_view json);
// What GET /v1/jobs/{id}/passes and .../light-groups answer.
std::string passes_to_json(std::string_view job, std::span<const std::string> layers);
std::string light_groups_to_json(std::string_view job, std::span<const std::string> groups);
// Of a job's statistics; empty: they name none.
std::vector<std::string> light_groups_of_stats(std::string_view stats_json);
std::string metrics_to_json(const JobMetrics& metrics);
std::string pixel_to_json(const PixelInfo& pixel);
std::string comparison_to_json(const Comparison& comparison);
std::string job_to_json(const JobInfo& job);
// `next`: the id to give as `before` for the following page; empty: this is the last.
std::string job_list_to_json(std::span<const JobInfo> jobs, std::string_view next);
// DELETE /v1/jobs: ids of the jobs; `more`: there are others that could be deleted.
std::string deleted_to_json(std::span<const std::string> jobs, bool more);
std::string table_to_json(const TableInfo& table);
// `next`: the last one of the page, where there are more; else empty.
std::string table_list_to_json(std::span<const TableInfo> tables, std::string_view next = {});
// `secret`: by which what it is sent is signed, told once; empty: not now.
std::string webhook_to_json(const WebhookInfo& webhook, std::string_view secret);
std::string webhook_list_to_json(std::span<const WebhookInfo> webhooks);
// What a webhook is sent when a job has ended.
std::string webhook_event(const JobInfo& job);
std::string weights_to_json(const WeightsInfo& weights);
std::string weights_list_to_json(std::span<const WeightsInfo> weights);
// `report`: of an uploaded scene.
std::string scene_to_json(const SceneInfo& scene, const SceneReport* report);
std::string scene_report_to_json(const SceneReport& report);
std::optional<SceneReport> parse_scene_report(std::string_view json);
std::string scene_list_to_json(std::span<const SceneInfo> scenes);
std::string asset_to_json(std::string_view sha256);
std::string health_to_json();
std::string problem_to_json(const Problem& problem);

std::string time_to_text(int64_t ms);  // "2026-01-01T00:00:00.000Z"
// The milliseconds of such a text; those and the seconds' fraction may be left out. In UTC alone.
std::optional<int64_t> parse_time(std::string_view text);

}  // namespace qray::proto
