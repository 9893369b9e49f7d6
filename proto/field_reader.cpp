#include "proto/field_reader.h"

#include "core/settings/frames.h"
#include "core/settings/job_settings.h"

namespace qray::proto {
namespace {

constexpr double kLeastLength = 1e-6;  // of directions and of distances to what is looked at

// Reads by one of ObjectReader's functions into a value of type T.
template <class T, class Read>
void take(const Field& field, JobRequest& out, Read read) {
  std::optional<T> value;
  read(value);
  if (value) out.set(field.path, FieldValue(std::move(*value)));
}

void read_whole(ObjectReader& in, const Field& field, const RequestLimits& limits,
                JobRequest& out) {
  if (const Json* value = in.find(field.name());
      value && value->is_string() && !field.zero.empty()) {
    if (value->get<std::string>() == field.zero)
      out.set(field.path, FieldValue(int64_t{0}));
    else
      in.wrong(field.name(), "expected " + expected(field, kJob) + ", got " + shown(*value));
    return;
  }
  take<int64_t>(field, out, [&](std::optional<int64_t>& value) {
    in.integer(field.name(), static_cast<int64_t>(field.least),
               static_cast<int64_t>(most_of(field, limits)), value);
    if (!value || *value % field.multiple_of == 0) return;
    in.wrong(field.name(),
             "expected " +
                 (field.multiple_of == 2 ? std::string("an even number")
                                         : "a multiple of " + std::to_string(field.multiple_of)) +
                 ", got " + std::to_string(*value));
  });
}

void read_choice(ObjectReader& in, const Field& field, unsigned caller, JobRequest& out) {
  const std::string* text = in.string(field.name());
  if (!text) return;
  const bool known = field.choices.empty() ||
                     std::any_of(field.choices.begin(), field.choices.end(), [&](const Choice& c) {
                       return (c.callers & caller) != 0 && c.value == *text;
                     });
  if (known || (!field.other.empty() && is_id(*text)))
    out.set(field.path, *text);
  else
    in.wrong(field.name(), "expected " + expected(field, caller) + ", got " + shown(*text));
}

void read_name(ObjectReader& in, const Field& field, unsigned caller, JobRequest& out) {
  const std::string* text = in.string(field.name());
  if (!text) return;
  if (is_name(*text))
    out.set(field.path, *text);
  else
    in.wrong(field.name(), "expected " + expected(field, caller));
}

void read_text(ObjectReader& in, const Field& field, unsigned caller, JobRequest& out) {
  const std::string* text = in.string(field.name());
  if (!text) return;
  if (text->size() <= kMaxText)
    out.set(field.path, *text);
  else
    in.wrong(field.name(), "expected " + expected(field, caller));
}

void read_names(ObjectReader& in, const Field& field, unsigned caller, JobRequest& out) {
  const Json* list = in.find(field.name());
  if (!list) return;
  const std::string at(field.name());
  if (!list->is_array() || list->size() > field.choices.size())
    return in.wrong(at, "expected " + expected(field, caller) + ", got " + shown(*list));
  Names names;
  for (size_t i = 0; i < list->size(); ++i) {
    const Json& name = (*list)[i];
    const bool known = name.is_string() && std::ranges::any_of(field.choices, [&](const Choice& c) {
                         return c.value == name.get_ref<const std::string&>();
                       });
    if (!known)
      return in.wrong(at + "/" + std::to_string(i),
                      "expected " + expected(field, caller) + ", got " + shown(name));
    names.push_back(name.get<std::string>());
  }
  if (!names.empty()) out.set(field.path, std::move(names));
}

void read_labels(ObjectReader& in, const Field& field, JobRequest& out) {
  const Json* labels = in.find(field.name());
  if (!labels) return;
  const std::string at(field.name());
  if (!labels->is_object() || labels->size() > kMaxLabels)
    return in.wrong(at, "expected an object of at most " + std::to_string(kMaxLabels) +
                            " texts by name, got " + shown(*labels));
  Labels read;
  for (const auto& [name, value] : labels->items()) {
    if (!is_name(name)) {
      in.wrong(at, "expected names of 1..64 of a-z, 0-9 and -, got " + shown(name));
    } else if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxLabelValue) {
      in.wrong(at + "/" + name, "expected text of at most " + std::to_string(kMaxLabelValue) +
                                    " bytes, got " + shown(value));
    } else {
      read[name] = value.get<std::string>();
    }
  }
  if (!read.empty()) out.set(field.path, std::move(read));
}

constexpr size_t kMaxCameraName = 256;  // bytes

double length_of(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void check_camera(ObjectReader& in, const CameraRequest& camera) {
  if (camera.up && length_of(*camera.up, {}) < kLeastLength)
    in.wrong("up", "expected a direction, got the zero vector");
  if (camera.position && camera.target &&
      length_of(*camera.position, *camera.target) < kLeastLength)
    in.wrong("target", "expected a point away from the position");
}

void read_cameras(ObjectReader& in, const Field& field, const FieldTable& fields, unsigned caller,
                  const RequestLimits& limits, JobRequest& out, std::vector<FieldError>& errors) {
  const Json* list = in.find(field.name());
  if (!list) return;
  if (!list->is_array() || list->empty() || list->size() > size_t{kMaxFrames})
    return in.wrong(field.name(), "expected 1.." + std::to_string(kMaxFrames) + " cameras, got " +
                                      (list->is_array() ? std::to_string(list->size()) + " items"
                                                        : shown(*list)));
  Cameras cameras;
  for (size_t i = 0; i < list->size(); ++i)
    cameras.push_back(read_camera((*list)[i], "/" + field.path + "/" + std::to_string(i), fields,
                                  caller, limits, errors));
  out.set(field.path, std::move(cameras));
}

}  // namespace

CameraChoice read_camera(const Json& tree, const std::string& pointer, const FieldTable& fields,
                         unsigned caller, const RequestLimits& limits,
                         std::vector<FieldError>& errors) {
  CameraChoice choice;
  if (tree.is_string()) {
    choice.name = tree.get<std::string>();
    if (choice.name.empty() || choice.name.size() > kMaxCameraName)
      errors.push_back({pointer, "expected a name of 1.." + std::to_string(kMaxCameraName) +
                                     " bytes, got " + std::to_string(choice.name.size())});
    return choice;
  }
  if (!tree.is_object()) {
    errors.push_back({pointer, "expected the name of a camera, or an object, got " + shown(tree)});
    return choice;
  }
  JobRequest given;
  ObjectReader members(tree, pointer, errors);
  for (const Field& field : fields)
    if (field.group() == "camera" && (field.callers & caller) != 0)
      read_field(members, field, caller, limits, given);
  members.refuse_unknown();
  if (const std::optional<CameraRequest> camera = camera_request(given)) {
    check_camera(members, *camera);
    choice.camera = *camera;
  }
  return choice;
}

double most_of(const Field& field, const RequestLimits& limits) {
  return field.path == field::kSeconds.path ? std::min(field.most, limits.max_seconds) : field.most;
}

void read_field(ObjectReader& in, const Field& field, unsigned caller, const RequestLimits& limits,
                JobRequest& out) {
  if (field.required && !in.find(field.name()))
    return in.wrong(field.name(), "expected " + expected(field, caller) + ", got nothing");
  switch (field.type) {
    case FieldType::kSwitch:
      return take<bool>(field, out, [&](auto& value) { in.boolean(field.name(), value); });
    case FieldType::kWhole:
      return read_whole(in, field, limits, out);
    case FieldType::kWhole64:
      return take<uint64_t>(field, out, [&](auto& value) {
        in.integer(field.name(), uint64_t{0}, UINT64_MAX, value);
      });
    case FieldType::kNumber:
      return take<double>(field, out, [&](auto& value) {
        in.number(field.name(), field.least, most_of(field, limits), value, field.above_least);
      });
    case FieldType::kVector:
      return take<Vector3>(field, out, [&](auto& value) { in.vec3(field.name(), value); });
    case FieldType::kChoice:
      return read_choice(in, field, caller, out);
    case FieldType::kName:
      return read_name(in, field, caller, out);
    case FieldType::kText:
      return read_text(in, field, caller, out);
    case FieldType::kLabels:
      return read_labels(in, field, out);
    case FieldType::kNames:
      return read_names(in, field, caller, out);
    case FieldType::kCameras:  // read_group() has what they are read by
      return;
  }
}

void read_group(ObjectReader& in, std::string_view group, const FieldTable& fields, unsigned caller,
                const RequestLimits& limits, JobRequest& out, std::vector<FieldError>& errors) {
  const Json* tree = in.find(group);
  if (!tree) return;
  if (!tree->is_object()) return in.wrong(group, "expected an object, got " + shown(*tree));
  const std::string method = out.get(field::kMethod);
  ObjectReader members(*tree, "/" + std::string(group), errors);
  for (const Field& field : fields) {
    if (field.group() != group || !(field.callers & caller)) continue;
    if (field.type == FieldType::kCameras)
      read_cameras(members, field, fields, caller, limits, out, errors);
    else if (field.of_method(method))
      read_field(members, field, caller, limits, out);
    else if (members.find(field.name()))
      members.wrong(field.name(), not_of_method(field, method));
  }
  if (group == "camera")
    if (const std::optional<CameraRequest> camera = camera_request(out))
      check_camera(members, *camera);
  if (group == "frames" && errors.empty())
    if (const Status good = check_frames(out); !good.ok())
      errors.push_back({good.error().where, good.error().message});
  members.refuse_unknown();
}

void read_fields(const Json& tree, const FieldTable& fields, unsigned caller,
                 const RequestLimits& limits, JobRequest& out, std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  std::set<std::string_view> groups;
  for (const Field& field : fields) {
    if (!(field.callers & caller)) continue;
    if (field.group().empty())
      read_field(in, field, caller, limits, out);
    else if (groups.insert(field.group()).second)
      read_group(in, field.group(), fields, caller, limits, out, errors);
  }
  in.refuse_unknown();
}

}  // namespace qray::proto
