#include "core/settings/field.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace qray {
namespace {

std::string with_dashes(std::string_view name) {
  std::string out(name);
  std::replace(out.begin(), out.end(), '_', '-');
  std::replace(out.begin(), out.end(), '/', '-');
  return out;
}

std::string whole_text(double v) { return std::to_string(static_cast<int64_t>(v)); }

std::string choices_text(const Field& field, unsigned caller) {
  std::string out;
  for (const Choice& choice : field.choices)
    if (choice.callers & caller) out += (out.empty() ? "" : ", ") + choice.value;
  return out;
}

template <class T>
std::optional<T> number_of(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Vector3> vector_of(std::string_view text) {
  Vector3 out{};
  for (size_t i = 0; i < 3; ++i) {
    const size_t end = i < 2 ? text.find(',') : text.size();
    if (end == std::string_view::npos) return std::nullopt;
    const std::optional<double> value = number_of<double>(text.substr(0, end));
    if (!value) return std::nullopt;
    out[i] = *value;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

bool is_choice(const Field& field, std::string_view text, unsigned caller) {
  if (field.choices.empty() || (!field.other.empty() && caller != kVariant)) return true;
  return std::any_of(field.choices.begin(), field.choices.end(), [&](const Choice& choice) {
    return (choice.callers & caller) != 0 && choice.value == text;
  });
}

// False where the text is not of the field's type.
bool read_text(const Field& field, std::string_view text, unsigned caller, FieldValue& out) {
  const auto take = [&out](const auto& value) {
    if (value) out = *value;
    return value.has_value();
  };
  switch (field.type) {
    case FieldType::kSwitch:
      out = text == "on";
      return text == "on" || text == "off";
    case FieldType::kWhole:
      if (!field.zero.empty() && text == field.zero) return take(std::optional<int64_t>(0));
      return take(number_of<int64_t>(text));
    case FieldType::kWhole64:
      return take(number_of<uint64_t>(text));
    case FieldType::kNumber:
      return take(number_of<double>(text));
    case FieldType::kVector:
      return take(vector_of(text));
    case FieldType::kLabels: {
      const size_t colon = text.find(':');
      if (colon == std::string_view::npos) return false;
      out = Labels{{std::string(text.substr(0, colon)), std::string(text.substr(colon + 1))}};
      return true;
    }
    case FieldType::kChoice:
      out = std::string(text);
      return is_choice(field, text, caller);
    case FieldType::kName:
      out = std::string(text);
      return true;
    case FieldType::kText:
      out = std::string(text);
      return text.size() <= kMaxText;
    case FieldType::kCameras:  // by name; what is not is JSON, which proto/ reads
      out = Cameras{{std::string(text), {}}};
      return !text.empty();
    case FieldType::kNames: {
      Names names;
      for (std::string_view rest = text; !rest.empty();) {
        const size_t end = std::min(rest.find(','), rest.size());
        names.emplace_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
      }
      out = names;
      return !names.empty() && std::ranges::all_of(names, [&](const std::string& name) {
        return is_choice(field, name, caller);
      });
    }
  }
  return false;
}

}  // namespace

std::string_view Field::group() const {
  const size_t slash = path.find('/');
  return slash == std::string::npos ? std::string_view() : std::string_view(path).substr(0, slash);
}

std::string_view Field::name() const {
  const size_t slash = path.find('/');
  return slash == std::string::npos ? path : std::string_view(path).substr(slash + 1);
}

std::string Field::option_name() const {
  return option.empty() ? (type == FieldType::kSwitch ? "--no-" : "--") + with_dashes(path)
                        : option;
}

std::string Field::variant_key() const { return key.empty() ? with_dashes(name()) : key; }

bool Field::of_method(std::string_view method) const {
  return methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end();
}

const Field* find_field(const FieldTable& fields, std::string_view path) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const Field& field) { return field.path == path; });
  return found == fields.end() ? nullptr : &*found;
}

std::string number_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string expected(const Field& field, unsigned caller) {
  switch (field.type) {
    case FieldType::kSwitch:
      return caller & (kJob | kLive) ? "true or false" : "on or off";
    case FieldType::kWhole:
      return "a whole number, " + whole_text(field.least) + ".." + whole_text(field.most) +
             (field.zero.empty() ? "" : ", or " + field.zero);
    case FieldType::kWhole64:
      return "a whole number, 0.." + std::to_string(UINT64_MAX);
    case FieldType::kNumber:
      return std::string("a number, ") + (field.above_least ? "above " : "") +
             number_text(field.least) + (field.above_least ? " to " : "..") +
             number_text(field.most);
    case FieldType::kChoice:
      return "one of " + choices_text(field, caller) +
             (field.other.empty() || caller == kVariant ? "" : " or " + field.other);
    case FieldType::kName:
      return "a name: 1..64 of a-z, 0-9 and -";
    case FieldType::kText:
      return "text of at most " + std::to_string(kMaxText) + " bytes";
    case FieldType::kVector:
      return caller & (kJob | kLive) ? "three numbers [x, y, z]" : "three numbers X,Y,Z";
    case FieldType::kLabels:
      return "NAME:VALUE";
    case FieldType::kCameras:
      return caller & (kJob | kLive) ? "a list of cameras: names of the scene's own, or objects"
                                     : "a camera: the name of one of the scene's, or JSON";
    case FieldType::kNames:
      return (caller & (kJob | kLive) ? "a list of some of " : "some, with commas between, of ") +
             choices_text(field, caller);
  }
  return "";
}

Status set_from_text(const Field& field, std::string_view text, unsigned caller,
                     JobRequest& request) {
  FieldValue value;
  if (!read_text(field, text, caller, value))
    return Error{ErrorCode::kInvalid,
                 "expected " + expected(field, caller) + ", got '" + std::string(text) + "'", ""};
  if (auto* labels = std::get_if<Labels>(&value))
    if (const FieldValue* before = request.find(field.path))
      labels->insert(std::get<Labels>(*before).begin(), std::get<Labels>(*before).end());
  if (auto* cameras = std::get_if<Cameras>(&value))
    if (const FieldValue* before = request.find(field.path))
      cameras->insert(cameras->begin(), std::get<Cameras>(*before).begin(),
                      std::get<Cameras>(*before).end());
  if (auto* names = std::get_if<Names>(&value))
    if (const FieldValue* before = request.find(field.path))
      names->insert(names->begin(), std::get<Names>(*before).begin(),
                    std::get<Names>(*before).end());
  request.set(field.path, std::move(value));
  return {};
}

std::string not_of_method(const Field& field, std::string_view method) {
  std::string have;
  for (const std::string& one : field.methods) have += (have.empty() ? "" : ", ") + one;
  return "the method " + std::string(method) + " has no such setting: it belongs to " + have;
}

double short_double(float value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  double out = 0;
  std::from_chars(text, end, out);
  return out;
}

}  // namespace qray
