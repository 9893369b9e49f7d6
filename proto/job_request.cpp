// The requests of jobs, scenes, tables and sessions.
#include "core/base/file_names.h"
#include "core/settings/frames.h"
#include "core/settings/job_settings.h"
#include "proto/field_reader.h"

namespace qray::proto {
namespace {

// As far as it can be judged before the scene says how large its picture is.
void check_region(const Json& tree, const JobRequest& request, std::vector<FieldError>& errors) {
  if (!tree.contains("region")) return;
  for (const char* side : {"/region/width", "/region/height"})
    if (!request.find(side + 1)) errors.push_back({side, "expected a whole number, got nothing"});
  if (request.get(field::kPixels) == pixels_name(Pixels::kByNoise))
    errors.push_back({"/region", "expected no region where pixels are sampled by their noise"});
}

void read_request(const Json& tree, const RequestLimits& limits, const FieldTable& fields,
                  JobRequest& out, std::vector<FieldError>& errors) {
  read_fields(tree, fields, kJob, limits, out, errors);
  const std::optional<int> width = out.given(field::kWidth), height = out.given(field::kHeight);
  if (const int64_t pixels = int64_t{width.value_or(1)} * height.value_or(1);
      width && height && pixels > limits.max_pixels)
    errors.push_back({"/width", "expected at most " + std::to_string(limits.max_pixels) +
                                    " pixels in all, got " + std::to_string(pixels)});
  if (tree.contains("samples") && tree.contains("seconds"))
    errors.push_back({"/seconds", "expected samples or seconds, got both"});
  const double seconds = out.given(field::kSeconds).value_or(0);
  const int frames = frame_count(out).value_or(1);
  if (frames > 1 && seconds * frames > limits.max_seconds)
    errors.push_back({"/seconds", "expected at most " + number_text(limits.max_seconds) +
                                      " s for all frames, got " + std::to_string(frames) + " of " +
                                      number_text(seconds) + " s"});
  check_region(tree, out, errors);
  complete_budget(out, limits.max_seconds);
}

// A request as older versions wrote it: settings of the guide beside the others, another name for
// the pixels that are chosen by noise.
Json in_todays_words(Json tree) {
  if (!tree.is_object()) return tree;
  if (tree.value("pixels", Json()) == "adaptive") tree["pixels"] = "by-noise";
  const Json::json_pointer at("/method");
  if (!tree.contains(at) || !tree[at].is_string()) return tree;
  const std::string method = tree[at];
  Json guide = tree.value("guide", Json::object());
  for (const char* name : {"alpha", "gamma", "grid"}) {
    if (!tree.contains(name)) continue;
    const Field* field = find_field(job_fields(), "guide/" + std::string(name));
    if (field && field->of_method(method)) guide[name] = tree[name];
    tree.erase(name);
  }
  if (!guide.empty()) tree["guide"] = std::move(guide);
  return tree;
}

FieldTable make_stored_fields() {
  FieldTable fields = job_fields();
  for (Field& field : fields) {
    if (field.path == field::kMethod.path) field.choices.clear();  // any
    if (field.path == field::kSeconds.path) field.most = 1e9;      // more was rendered onto it
  }
  return fields;
}

void read_extend(const Json& tree, const RequestLimits& limits, ExtendRequest& out,
                 std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  JobRequest more;
  for (const std::string_view path :
       {field::kSamples.path, field::kSeconds.path, field::kNoise.path})
    read_field(in, *find_field(job_fields(), path), kJob, limits, more);
  in.refuse_unknown();
  out = {more.given(field::kSamples), more.given(field::kSeconds), more.given(field::kNoise)};
  if (out.samples && out.seconds) in.wrong("seconds", "expected samples or seconds, got both");
  if (errors.empty() && !out.samples && !out.seconds) {
    if (!out.noise) errors.push_back({"", "expected samples, seconds or noise, got none of them"});
    out.seconds = limits.max_seconds;
  }
}

void read_update(const Json& tree, const RequestLimits& limits, JobUpdate& out,
                 std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  JobRequest given;
  for (const std::string_view path : {field::kLabels.path, field::kPriority.path})
    read_field(in, *find_field(job_fields(), path), kJob, limits, given);
  in.refuse_unknown();
  out = {given.given(field::kLabels), given.given(field::kPriority)};
  if (errors.empty() && tree.contains("labels") && !out.labels) out.labels.emplace();  // none
  if (errors.empty() && !out.labels && !out.priority)
    errors.push_back({"", "expected labels or priority, got none of them"});
}

void read_merge(const Json& tree, std::vector<std::string>& tables,
                std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  const Json* list = in.find("tables");
  if (!list || !list->is_array() || list->size() < 2 || list->size() > kMaxMergedTables) {
    in.wrong("tables", "expected 2.." + std::to_string(kMaxMergedTables) + " ids of tables, got " +
                           (!list              ? "nothing"
                            : list->is_array() ? std::to_string(list->size())
                                               : shown(*list)));
  } else {
    for (size_t i = 0; i < list->size(); ++i) {
      const Json& item = (*list)[i];
      const std::string at = "tables/" + std::to_string(i);
      if (!item.is_string() || !is_id(item.get_ref<const std::string&>())) {
        in.wrong(at, "expected a table's id (32 hex digits), got " + shown(item));
        continue;
      }
      std::string id = item.get<std::string>();
      if (std::find(tables.begin(), tables.end(), id) != tables.end())
        in.wrong(at, "expected different tables, got one twice");
      tables.push_back(std::move(id));
    }
  }
  in.refuse_unknown();
}

void read_session(const Json& tree, std::string& token, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  if (const std::string* text = in.string("token")) token = *text;
  if (!tree.contains("token")) in.wrong("token", "expected a token, got nothing");
  in.refuse_unknown();
}

void read_webhook(const Json& tree, std::string& url, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  if (const std::string* text = in.string("url")) url = *text;
  if (!tree.contains("url")) in.wrong("url", "expected an address, got nothing");
  in.refuse_unknown();
}

bool is_sha256(const Json& value) {
  const std::string* text = value.get_ptr<const std::string*>();
  return text && text->size() == 64 &&
         text->find_first_not_of("0123456789abcdef") == std::string::npos;
}

constexpr const char* kExpectedSha256 = "expected a SHA-256 (64 digits of 0-9 and a-f), got ";

void read_files(const Json& files, SceneRequest& out, std::vector<FieldError>& errors) {
  if (!files.is_object() || files.empty()) {
    errors.push_back({"/files", "expected an object of names and SHA-256s, got " + shown(files)});
    return;
  }
  FileNames names;
  for (const auto& [name, hash] : files.items()) {
    if (const auto fault = names.add(name)) errors.push_back({file_pointer(name), *fault});
    if (!is_sha256(hash)) errors.push_back({file_pointer(name), kExpectedSha256 + shown(hash)});
    if (errors.size() >= 32) return;
    out.files[name] = hash.is_string() ? hash.get<std::string>() : "";
  }
}

constexpr size_t kMostTitle = 120;  // bytes

// Shown as it is, in one line.
void read_title(ObjectReader& in, std::string& out) {
  const std::string* title = in.string("title");
  if (!title) return;
  out = *title;
  if (out.empty() || out.size() > kMostTitle ||
      std::any_of(out.begin(), out.end(), [](unsigned char c) { return c < 32 || c == 127; }))
    in.wrong("title", "expected one line of 1 to " + std::to_string(kMostTitle) + " bytes");
}

void read_scene_files(const Json& tree, SceneRequest& out, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  const Json* files = in.find("files");
  const Json* asset = in.find("asset");
  std::string type;
  in.one_of("type", {"glb", "zip"}, type);
  if (const std::string* entry = in.string("entry")) out.entry = *entry;
  read_title(in, out.title);
  in.refuse_unknown();
  if (!files == !asset) {
    errors.push_back({"", std::string("expected \"files\" or \"asset\", got ") +
                              (files ? "both" : "none of the two")});
  } else if (files) {
    read_files(*files, out, errors);
    if (!out.entry.empty() && errors.empty() && !out.files.contains(out.entry))
      in.wrong("entry", "expected one of the files, got " + shown(out.entry));
    if (!type.empty()) in.wrong("type", "belongs to \"asset\"");
  } else if (!is_sha256(*asset)) {
    in.wrong("asset", kExpectedSha256 + shown(*asset));
  } else if (type == "glb") {
    out.files["scene.glb"] = asset->get<std::string>();
    if (!out.entry.empty()) in.wrong("entry", "a .glb is a scene by itself");
    out.entry = "scene.glb";
  } else {
    out.archive = asset->get<std::string>();
    if (type.empty() && errors.empty()) in.wrong("type", "expected glb or zip, got nothing");
    if (const auto fault = FileNames().add(out.entry); fault && !out.entry.empty())
      in.wrong("entry", *fault);
  }
}

}  // namespace

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

std::variant<CameraRequest, Problem> parse_camera(std::string_view json) {
  return parse_request<CameraRequest>(
      json, {}, "Wrong camera",
      [](const Json& tree, CameraRequest& out, std::vector<FieldError>& errors) {
        out = read_camera(tree, "", job_fields(), kJob, {}, errors).camera;
      });
}

std::variant<JobRequest, Problem> parse_frames(std::string_view json) {
  return parse_request<JobRequest>(
      json, {}, "Wrong frames",
      [](const Json& tree, JobRequest& out, std::vector<FieldError>& errors) {
        const Json request = {{"frames", tree}};
        ObjectReader in(request, "", errors);
        read_group(in, "frames", job_fields(), kJob, {}, out, errors);
      });
}

std::variant<JobRequest, Problem> parse_job_request(std::string_view json,
                                                    const RequestLimits& limits,
                                                    const FieldTable& fields) {
  const auto read = [&](const Json& tree, JobRequest& request, std::vector<FieldError>& errors) {
    read_request(tree, limits, fields, request, errors);
  };
  return parse_request<JobRequest>(json, limits, "Wrong job request", read);
}

std::variant<JobRequest, Problem> parse_stored_request(std::string_view json) {
  static const FieldTable fields = make_stored_fields();
  RequestLimits limits;
  limits.max_seconds = 1e9;
  limits.max_pixels = INT64_MAX;
  const auto read = [&](const Json& tree, JobRequest& request, std::vector<FieldError>& errors) {
    read_request(in_todays_words(tree), limits, fields, request, errors);
  };
  return parse_request<JobRequest>(json, limits, "Wrong stored request", read);
}

std::variant<ExtendRequest, Problem> parse_extend_request(std::string_view json,
                                                          const RequestLimits& limits) {
  const auto read = [&](const Json& tree, ExtendRequest& request, std::vector<FieldError>& errors) {
    read_extend(tree, limits, request, errors);
  };
  return parse_request<ExtendRequest>(json, limits, "Wrong request for more", read);
}

std::variant<JobUpdate, Problem> parse_job_update(std::string_view json,
                                                  const RequestLimits& limits) {
  const auto read = [&](const Json& tree, JobUpdate& update, std::vector<FieldError>& errors) {
    read_update(tree, limits, update, errors);
  };
  return parse_request<JobUpdate>(json, limits, "Wrong change of a job", read);
}

std::variant<SceneRequest, Problem> parse_scene_request(std::string_view json,
                                                        const RequestLimits& limits) {
  return parse_request<SceneRequest>(json, limits, "Wrong scene", read_scene_files);
}

std::variant<std::string, Problem> parse_title_request(std::string_view json,
                                                       const RequestLimits& limits) {
  const auto read = [](const Json& tree, std::string& title, std::vector<FieldError>& errors) {
    ObjectReader in(tree, "", errors);
    if (tree.is_object() && !tree.contains("title")) in.wrong("title", "is missing");
    read_title(in, title);
    in.refuse_unknown();
  };
  return parse_request<std::string>(json, limits, "Wrong title", read);
}

std::variant<std::vector<std::string>, Problem> parse_merge_request(std::string_view json,
                                                                    const RequestLimits& limits) {
  return parse_request<std::vector<std::string>>(json, limits, "Wrong merge request", read_merge);
}

std::variant<std::string, Problem> parse_webhook_request(std::string_view json,
                                                         const RequestLimits& limits) {
  return parse_request<std::string>(json, limits, "Wrong webhook", read_webhook);
}

std::variant<std::string, Problem> parse_session_request(std::string_view json,
                                                         const RequestLimits& limits) {
  return parse_request<std::string>(json, limits, "Wrong session request", read_session);
}

}  // namespace qray::proto
