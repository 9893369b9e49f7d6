#include "core/import/json_tree.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

namespace qray {
namespace {

// RFC 6901.
std::string escape(std::string_view key) {
  std::string out;
  for (const char c : key) {
    if (c == '~')
      out += "~0";
    else if (c == '/')
      out += "~1";
    else
      out += c;
  }
  return out;
}

std::string quote(std::string_view text) {
  constexpr size_t kShown = 60;
  const bool whole = text.size() <= kShown;
  return '"' + std::string(text.substr(0, kShown)) + (whole ? "\"" : "...\"");
}

std::string describe(const JsonValue& v) {
  if (const double* number = std::get_if<double>(&v.value)) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", *number);
    return text;
  }
  if (const std::string* text = std::get_if<std::string>(&v.value)) return quote(*text);
  if (const bool* truth = std::get_if<bool>(&v.value)) return *truth ? "true" : "false";
  if (const auto* array = std::get_if<JsonValue::Array>(&v.value))
    return "an array of " + std::to_string(array->size());
  return std::holds_alternative<JsonValue::Object>(v.value) ? "an object" : "null";
}

float to_float(double v) {
  constexpr double kMax = std::numeric_limits<float>::max();
  if (std::abs(v) > kMax) return static_cast<float>(std::copysign(HUGE_VAL, v));
  return static_cast<float>(v);
}

// Events of nlohmann's iterative SAX parser -> tree. An exception in a handler ends the parse.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::span<const uint8_t> text, const std::string& file, size_t max_values,
              JsonValue& root)
      : text_(text), file_(file), values_left_(max_values), root_(root) {}

  bool null() override { return add({}); }
  bool boolean(bool v) override { return add({v}); }
  bool number_integer(int64_t v) override { return add({static_cast<double>(v)}); }
  bool number_unsigned(uint64_t v) override { return add({static_cast<double>(v)}); }
  bool number_float(double v, const std::string&) override { return add({v}); }
  bool string(std::string& v) override { return add({std::move(v)}); }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(size_t) override { return open({JsonValue::Object{}}); }
  bool start_array(size_t) override { return open({JsonValue::Array{}}); }
  bool end_object() override {
    refuse_twice();
    return close();
  }
  bool end_array() override { return close(); }

  bool key(std::string& name) override {
    std::get<JsonValue::Object>(open_.back()->value).push_back({std::move(name), {}});
    return true;
  }

  bool parse_error(size_t position, const std::string&,
                   const nlohmann::json::exception& e) override {
    const auto end = text_.begin() + static_cast<ptrdiff_t>(std::min(position, text_.size()));
    const auto line = 1 + std::count(text_.begin(), end, static_cast<uint8_t>('\n'));
    const std::string what = e.what();
    const size_t detail = what.find(": ", what.find("column"));
    fail_import(ErrorCode::kInvalid,
                "not JSON" + (detail == std::string::npos ? "" : what.substr(detail)),
                file_ + ":" + std::to_string(line));
  }

 private:
  // Once the object is whole: looking at all before it with each key would take a square of time.
  void refuse_twice() const {
    const auto& object = std::get<JsonValue::Object>(open_.back()->value);
    std::vector<std::string_view> keys;
    for (const JsonMember& member : object) keys.push_back(member.key);
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) fail_import(ErrorCode::kInvalid, "appears twice", pointer(*twice));
  }

  JsonValue* place(JsonValue v) {
    JsonValue* slot = &root_;
    if (!open_.empty()) {
      if (auto* array = std::get_if<JsonValue::Array>(&open_.back()->value))
        slot = &array->emplace_back();
      else
        slot = &std::get<JsonValue::Object>(open_.back()->value).back().value;
    }
    *slot = std::move(v);
    if (values_left_-- == 0) fail_import(ErrorCode::kTooLarge, "has too many values", file_);
    return slot;
  }
  bool add(JsonValue v) {
    place(std::move(v));
    return true;
  }
  // Addresses of open values are stable: only the innermost one's children are appended to.
  bool open(JsonValue v) {
    open_.push_back(place(std::move(v)));
    if (open_.size() > kMaxJsonDepth) {
      open_.pop_back();
      fail_import(
          ErrorCode::kTooLarge,
          "nested too deeply, expected at most " + std::to_string(kMaxJsonDepth) + " levels",
          pointer({}));
    }
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }
  std::string pointer(std::string_view last_key) const {
    std::string out = file_ + ":";
    for (size_t i = 0; i < open_.size(); ++i) {
      if (const auto* array = std::get_if<JsonValue::Array>(&open_[i]->value))
        out += "/" + std::to_string(array->size() - 1);
      else if (i + 1 < open_.size() || last_key.empty())
        out += "/" + escape(std::get<JsonValue::Object>(open_[i]->value).back().key);
    }
    return last_key.empty() ? out : out + "/" + escape(last_key);
  }

  std::span<const uint8_t> text_;
  const std::string& file_;
  size_t values_left_;
  JsonValue& root_;
  std::vector<JsonValue*> open_;
};

}  // namespace

JsonValue parse_json(std::span<const uint8_t> text, const std::string& file, size_t max_values) {
  JsonValue root;
  TreeBuilder builder(text, file, max_values, root);
  nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  return root;
}

void JsonNode::fail(const std::string& message, ErrorCode code) const {
  // The root's place ends with the colon before its empty pointer.
  fail_import(code, message, place_.ends_with(':') ? place_.substr(0, place_.size() - 1) : place_);
}
void JsonNode::fail_expected(const std::string& what) const {
  fail("expected " + what + ", got " + describe(*value_));
}

bool JsonNode::boolean() const {
  const bool* v = std::get_if<bool>(&value_->value);
  if (!v) fail_expected("true or false");
  return *v;
}

float JsonNode::number() const {
  const double* v = std::get_if<double>(&value_->value);
  if (!v) fail_expected("a number");
  return to_float(*v);
}

float JsonNode::number(float lo, float hi) const {
  const float v = number();
  if (!(v >= lo && v <= hi)) {
    char text[64];
    std::snprintf(text, sizeof text, "%g..%g", static_cast<double>(lo), static_cast<double>(hi));
    fail_expected(text);
  }
  return v;
}

int JsonNode::integer(int lo, int hi) const {
  const double* v = std::get_if<double>(&value_->value);
  if (!v || *v != std::floor(*v) || *v < lo || *v > hi)
    fail_expected("an integer, " + std::to_string(lo) + ".." + std::to_string(hi));
  return static_cast<int>(*v);
}

const std::string& JsonNode::string() const {
  const std::string* v = std::get_if<std::string>(&value_->value);
  if (!v) fail_expected("a string");
  return *v;
}

size_t JsonNode::size() const {
  const auto* v = std::get_if<JsonValue::Array>(&value_->value);
  if (!v) fail_expected("an array");
  return v->size();
}

JsonNode JsonNode::at(size_t index) const {
  return {std::get<JsonValue::Array>(value_->value)[index], place_ + "/" + std::to_string(index)};
}

std::vector<float> JsonNode::numbers(size_t count, float limit) const {
  const std::vector<double> read = doubles(count, limit);
  std::vector<float> out(count);
  std::transform(read.begin(), read.end(), out.begin(), to_float);
  return out;
}

std::vector<double> JsonNode::doubles(size_t count, float limit) const {
  if (!is_array() || size() != count)
    fail_expected("an array of " + std::to_string(count) + " numbers");
  std::vector<double> out(count);
  const auto& items = std::get<JsonValue::Array>(value_->value);
  for (size_t i = 0; i < count; ++i) {
    const double* v = std::get_if<double>(&items[i].value);
    const bool good = v && std::abs(*v) <= static_cast<double>(limit);
    out[i] = good ? *v : double{at(i).number(-limit, limit)};  // at() names the place
  }
  return out;
}

Vec3 JsonNode::vec3() const {
  const std::vector<float> v = numbers(3);
  return {v[0], v[1], v[2]};
}

Vec3 JsonNode::direction() const {
  const Vec3 v = vec3();
  if (!(length(v) > 0)) fail("expected a direction, got one of no length");
  return v;
}

Rgb JsonNode::number_or_rgb() const {
  if (is_number()) return Rgb{number()};
  if (!is_array()) fail_expected("a number or [r, g, b]");
  const std::vector<float> v = numbers(3, std::numeric_limits<float>::max());
  return {v[0], v[1], v[2]};
}

const JsonValue::Object& JsonNode::object() const {
  const auto* v = std::get_if<JsonValue::Object>(&value_->value);
  if (!v) fail_expected("an object");
  return *v;
}

void JsonNode::only(const std::vector<std::string_view>& keys) const {
  for (const JsonMember& member : object()) {
    if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
    std::string known;
    for (const std::string_view key : keys) known += (known.empty() ? "" : ", ") + std::string(key);
    JsonNode(member.value, place_ + "/" + escape(member.key))
        .fail("unknown field, expected one of: " + known);
  }
}

std::optional<JsonNode> JsonNode::find(std::string_view key) const {
  for (const JsonMember& member : object())
    if (member.key == key) return JsonNode(member.value, place_ + "/" + escape(key));
  return std::nullopt;
}

std::vector<std::string> JsonNode::keys() const {
  std::vector<std::string> out;
  for (const JsonMember& member : object()) out.push_back(member.key);
  return out;
}

JsonNode JsonNode::get(std::string_view key) const {
  std::optional<JsonNode> node = find(key);
  if (!node) fail("\"" + std::string(key) + "\" is missing");
  return *node;
}

}  // namespace qray
