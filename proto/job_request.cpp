// Strict reading of requests: every field that is wrong is reported, by pointer. One file, as all
// read through the same parser, behind the same wall.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/base/file_names.h"
#include "proto/messages.h"

namespace qray::proto {
namespace {

using Json = nlohmann::json;

// The parser and the tree's destructor recurse or grow with depth, so it is bounded beforehand.
bool deeper_than(std::string_view text, int limit) {
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > limit) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

Problem problem(int status, std::string title, std::string detail) {
  return {status, std::move(title), std::move(detail), {}};
}

// A tree, or why not. Names given twice are an error: readers disagree on which one counts.
std::variant<Json, Problem> parse_tree(std::string_view text, const RequestLimits& limits) {
  if (text.size() > limits.max_bytes) {
    return problem(413, "Content too large",
                   "expected at most " + std::to_string(limits.max_bytes) + " bytes, got " +
                       std::to_string(text.size()));
  }
  if (deeper_than(text, limits.max_nesting)) {
    return problem(400, "Not acceptable JSON",
                   "expected at most " + std::to_string(limits.max_nesting) + " levels of nesting");
  }
  std::vector<std::set<std::string>> names;
  bool twice = false;
  const auto watch = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) names.emplace_back();
    if (event == Json::parse_event_t::object_end) names.pop_back();
    if (event == Json::parse_event_t::key) {
      twice |= !names.back().insert(value.get_ref<const std::string&>()).second;
    }
    return true;
  };
  try {
    Json tree = Json::parse(text.begin(), text.end(), watch);
    if (twice) return problem(400, "Not acceptable JSON", "an object has a name twice");
    return tree;
  } catch (const Json::parse_error& e) {
    return problem(400, "Not JSON", "not JSON at byte " + std::to_string(e.byte));
  } catch (const Json::exception&) {
    return problem(400, "Not acceptable JSON", "a number is too large for a 64-bit float");
  }
}

std::string number_text(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

// A short form of what came, for messages. Text is cut; the reply's writer repairs cut UTF-8.
std::string shown(const Json& value) {
  std::string text = value.is_structured()
                         ? std::string(value.is_array() ? "an array" : "an object")
                         : value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 60) + "...";
  return text;
}

// Reads the members of one object; what is wrong is added to `errors`.
class ObjectReader {
 public:
  ObjectReader(const Json& object, std::string pointer, std::vector<FieldError>& errors)
      : object_(object), pointer_(std::move(pointer)), errors_(errors) {}

  const Json* find(const char* name) {
    known_.insert(name);
    const auto it = object_.find(name);
    return it == object_.end() ? nullptr : &*it;
  }
  void wrong(const std::string& name, std::string detail) {
    errors_.push_back({pointer_ + "/" + name, std::move(detail)});
  }

  template <class T, class Out>
  void integer(const char* name, T least, T most, Out& out) {
    const Json* value = find(name);
    if (!value) return;
    const auto take = [&](auto v) {
      if (std::cmp_less(v, least) || std::cmp_greater(v, most)) return false;
      out = static_cast<T>(v);
      return true;
    };
    if (value->is_number_unsigned() ? take(value->get<uint64_t>())
                                    : value->is_number_integer() && take(value->get<int64_t>()))
      return;
    // Numbers such as 64.0 and 1e3 are whole too; JSON does not tell them apart.
    if (value->is_number_float()) {
      const double v = value->get<double>();
      if (v == std::floor(v) && v >= static_cast<double>(least) && v <= 9007199254740992.0 &&
          v <= static_cast<double>(most)) {
        out = static_cast<T>(v);
        return;
      }
    }
    wrong(name, "expected a whole number, " + std::to_string(least) + ".." + std::to_string(most) +
                    ", got " + shown(*value));
  }

  // `least` and `most` are allowed; `above_least`: `least` is not.
  template <class Out>
  void number(const char* name, double least, double most, Out& out, bool above_least = false) {
    const Json* value = find(name);
    if (!value) return;
    const double v = value->is_number() ? value->get<double>() : NAN;
    if (v >= least && v <= most && !(above_least && v == least)) {
      out = v;
    } else {
      wrong(name, std::string("expected a number, ") + (above_least ? "above " : "") +
                      number_text(least) + (above_least ? " to " : "..") + number_text(most) +
                      ", got " + shown(*value));
    }
  }

  void boolean(const char* name, bool& out) {
    const Json* value = find(name);
    if (!value) return;
    if (value->is_boolean()) {
      out = value->get<bool>();
    } else {
      wrong(name, "expected true or false, got " + shown(*value));
    }
  }

  const std::string* string(const char* name) {
    const Json* value = find(name);
    if (!value) return nullptr;
    if (value->is_string()) return value->get_ptr<const std::string*>();
    wrong(name, "expected text, got " + shown(*value));
    return nullptr;
  }

  void one_of(const char* name, std::initializer_list<std::string_view> names, std::string& out,
              const char* or_else = "") {
    const std::string* value = string(name);
    if (!value) return;
    if (std::find(names.begin(), names.end(), *value) != names.end()) {
      out = *value;
      return;
    }
    std::string known;
    for (std::string_view n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    wrong(name, "expected one of " + known + or_else + ", got " + shown(*value));
  }

  void vec3(const char* name, std::optional<std::array<double, 3>>& out) {
    const Json* value = find(name);
    if (!value) return;
    if (!value->is_array() || value->size() != 3) {
      return wrong(
          name, "expected three numbers [x, y, z], got " +
                    (value->is_array() ? std::to_string(value->size()) + " items" : shown(*value)));
    }
    std::array<double, 3> v{};
    for (size_t i = 0; i < 3; ++i) {
      const Json& item = (*value)[i];
      v[i] = item.is_number() ? item.get<double>() : NAN;
      if (!(std::abs(v[i]) <= 1e6)) {
        return wrong(std::string(name) + "/" + std::to_string(i),
                     "expected a number, -1e6..1e6 metres, got " + shown(item));
      }
    }
    out = v;
  }

  void refuse_unknown() {
    for (const auto& [name, value] : object_.items()) {
      if (known_.contains(name)) continue;
      std::string escaped;  // RFC 6901
      for (char c : name.substr(0, 60))
        escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
      wrong(escaped, "unknown field");
      if (errors_.size() >= 32) return;
    }
  }

 private:
  const Json& object_;
  std::string pointer_;
  std::vector<FieldError>& errors_;
  std::set<std::string, std::less<>> known_;
};

constexpr int kMostSamples = 1'000'000;  // a pixel

// Of a table, or of weights.
bool is_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

double length_of(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void read_camera(const Json& tree, CameraRequest& camera, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "/camera", errors);
  in.vec3("position", camera.position);
  in.vec3("target", camera.target);
  in.vec3("up", camera.up);
  in.number("vertical_fov_deg", 0.1, 179, camera.vertical_fov_deg);
  in.number("aperture_radius", 0, 1e6, camera.aperture_radius);
  in.number("focus_distance", 0, 1e6, camera.focus_distance);
  if (camera.up && length_of(*camera.up, {}) < 1e-6) {
    in.wrong("up", "expected a direction, got the zero vector");
  }
  if (camera.position && camera.target && length_of(*camera.position, *camera.target) < 1e-6) {
    in.wrong("target", "expected a point away from the position");
  }
  in.refuse_unknown();
}

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
  if (const std::string* scene = in.string("scene")) {
    out.scene = *scene;
    if (!is_name(out.scene)) in.wrong("scene", "expected a scene's name: 1..64 of a-z, 0-9 and -");
  } else if (!tree.contains("scene")) {
    in.wrong("scene", "expected a scene's name, got nothing");
  }
  in.integer("width", 1, limits.max_dimension_px, out.width);
  in.integer("height", 1, limits.max_dimension_px, out.height);
  if (out.width && out.height && int64_t{*out.width} * *out.height > limits.max_pixels) {
    in.wrong("width", "expected at most " + std::to_string(limits.max_pixels) +
                          " pixels in all, got " +
                          std::to_string(int64_t{*out.width} * *out.height));
  }
  if (const std::string* method = in.string("method")) {
    out.method = *method;
    const auto& known_methods = limits.methods;
    if (!known_methods.empty() &&
        std::find(known_methods.begin(), known_methods.end(), out.method) == known_methods.end()) {
      std::string known;
      for (const std::string& name : known_methods) known += (known.empty() ? "" : ", ") + name;
      in.wrong("method", "expected one of " + known + ", got " + shown(*method));
    }
  }
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
  if (const std::string* table = in.string("table")) {
    out.table = *table;
    if (out.table != "auto" && out.table != "none" && !is_id(out.table)) {
      in.wrong("table",
               "expected auto, none or a table's id (32 hex digits), got " + shown(*table));
    }
  }
  in.one_of("pixels", {"all", "quarter", "adaptive"}, out.pixels);
  if (const std::string* recover = in.string("recover"); recover && is_id(*recover)) {
    out.recover = *recover;
  } else if (recover) {
    in.one_of("recover", {"none", "auto", "bilinear", "untrained", "default"}, out.recover,
              " or the id of weights (32 hex digits)");
  }
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

void read_scene(const Json& tree, SceneRequest& out, std::vector<FieldError>& errors) {
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

// A request that `read(tree, request, errors)` takes apart.
template <class Request, class Read>
std::variant<Request, Problem> parse_request(std::string_view json, const RequestLimits& limits,
                                             std::string title, Read read) {
  std::variant<Json, Problem> parsed = parse_tree(json, limits);
  if (Problem* bad = std::get_if<Problem>(&parsed)) return std::move(*bad);
  const Json& tree = std::get<Json>(parsed);
  Problem wrong = problem(422, std::move(title), "");
  Request request;
  if (!tree.is_object()) {
    wrong.errors.push_back({"", "expected an object, got " + shown(tree)});
  } else {
    read(tree, request, wrong.errors);
  }
  if (wrong.errors.empty()) return request;
  wrong.detail = wrong.errors.front().pointer + ": " + wrong.errors.front().detail;
  return wrong;
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
  return parse_request<SceneRequest>(json, limits, "Wrong scene", read_scene);
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
