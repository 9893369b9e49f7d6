// The requests of jobs, scenes, tables and sessions.
#include "core/base/file_names.h"
#include "proto/scene_members.h"

namespace qray::proto {
namespace {

constexpr int kMostSamples = 1'000'000;  // a pixel

void read_labels(const Json& labels, std::map<std::string, std::string>& out,
                 std::vector<FieldError>& errors) {
  const auto wrong = [&](std::string pointer, std::string detail) {
    errors.push_back({"/labels" + std::move(pointer), std::move(detail)});
  };
  if (!labels.is_object() || labels.size() > kMaxLabels)
    return wrong("", "expected an object of at most " + std::to_string(kMaxLabels) +
                         " texts by name, got " + shown(labels));
  for (const auto& [name, value] : labels.items()) {
    if (!is_name(name)) {
      wrong("", "expected names of 1..64 of a-z, 0-9 and -, got " + shown(name));
    } else if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxLabelValue) {
      wrong("/" + name, "expected text of at most " + std::to_string(kMaxLabelValue) +
                            " bytes, got " + shown(value));
    } else {
      out[name] = value.get<std::string>();
    }
  }
}

void read_request(const Json& tree, const RequestLimits& limits, JobRequest& out,
                  std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  read_scene(in, out.scene);
  in.integer("width", 1, limits.max_dimension_px, out.width);
  in.integer("height", 1, limits.max_dimension_px, out.height);
  if (out.width && out.height && int64_t{*out.width} * *out.height > limits.max_pixels) {
    in.wrong("width", "expected at most " + std::to_string(limits.max_pixels) +
                          " pixels in all, got " +
                          std::to_string(int64_t{*out.width} * *out.height));
  }
  read_method(in, limits, out.method);
  in.boolean("nee", out.nee);
  in.integer("samples", 1, kMostSamples, out.samples);
  in.number("seconds", 0, limits.max_seconds, out.seconds, /*above_least=*/true);
  if (tree.contains("samples") && tree.contains("seconds")) {
    in.wrong("seconds", "expected samples or seconds, got both");
  } else if (!tree.contains("samples") && !tree.contains("seconds")) {
    if (tree.contains("noise")) {
      out.seconds = limits.max_seconds;
    } else {
      out.samples = 64;
    }
  }
  in.number("noise", 0, 1, out.noise, /*above_least=*/true);
  in.integer("seed", uint64_t{0}, UINT64_MAX, out.seed);
  read_table(in, out.table);
  in.one_of("pixels", {"all", "quarter", "adaptive"}, out.pixels);
  read_recover(in, {"none", "auto", "bilinear", "untrained", "default"}, out.recover);
  in.integer("max_depth", 1, 128, out.max_depth);
  in.integer("learning_samples", 0, 1'000'000, out.learning_samples);
  in.number("alpha", 0, 1, out.alpha);
  in.number("gamma", 0, 1, out.gamma);
  in.integer("grid", 1, limits.max_grid, out.grid);
  if (const Json* camera = in.find("camera")) {
    if (camera->is_object()) {
      read_camera(*camera, out.camera.emplace(), errors);
    } else {
      in.wrong("camera", "expected an object, got " + shown(*camera));
    }
  }
  in.integer("priority", -kMaxPriority, kMaxPriority, out.priority);
  if (const Json* labels = in.find("labels")) read_labels(*labels, out.labels, errors);
  in.refuse_unknown();
}

void read_extend(const Json& tree, const RequestLimits& limits, ExtendRequest& out,
                 std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  in.integer("samples", 1, kMostSamples, out.samples);
  in.number("seconds", 0, limits.max_seconds, out.seconds, /*above_least=*/true);
  in.number("noise", 0, 1, out.noise, /*above_least=*/true);
  in.refuse_unknown();
  if (out.samples && out.seconds) in.wrong("seconds", "expected samples or seconds, got both");
  if (errors.empty() && !out.samples && !out.seconds) {
    if (!out.noise) errors.push_back({"", "expected samples, seconds or noise, got none of them"});
    out.seconds = limits.max_seconds;
  }
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

void read_scene_files(const Json& tree, SceneRequest& out, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  const Json* files = in.find("files");
  const Json* asset = in.find("asset");
  std::string type;
  in.one_of("type", {"glb", "zip"}, type);
  if (const std::string* entry = in.string("entry")) out.entry = *entry;
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

std::variant<JobRequest, Problem> parse_job_request(std::string_view json,
                                                    const RequestLimits& limits) {
  const auto read = [&](const Json& tree, JobRequest& request, std::vector<FieldError>& errors) {
    read_request(tree, limits, request, errors);
  };
  return parse_request<JobRequest>(json, limits, "Wrong job request", read);
}

std::variant<ExtendRequest, Problem> parse_extend_request(std::string_view json,
                                                          const RequestLimits& limits) {
  const auto read = [&](const Json& tree, ExtendRequest& request, std::vector<FieldError>& errors) {
    read_extend(tree, limits, request, errors);
  };
  return parse_request<ExtendRequest>(json, limits, "Wrong request for more", read);
}

std::variant<SceneRequest, Problem> parse_scene_request(std::string_view json,
                                                        const RequestLimits& limits) {
  return parse_request<SceneRequest>(json, limits, "Wrong scene", read_scene_files);
}

std::variant<std::vector<std::string>, Problem> parse_merge_request(std::string_view json,
                                                                    const RequestLimits& limits) {
  return parse_request<std::vector<std::string>>(json, limits, "Wrong merge request", read_merge);
}

std::variant<std::string, Problem> parse_session_request(std::string_view json,
                                                         const RequestLimits& limits) {
  return parse_request<std::string>(json, limits, "Wrong session request", read_session);
}

}  // namespace qray::proto
