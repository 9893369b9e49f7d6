// JSON text -> a small tree, and checked access to it. The reader bounds the depth, refuses
// duplicate keys and stops at a count of values; JsonNode knows its place
// ("scene.json:/materials/3/ior") and throws ImportFailure naming it. Any thread.
#pragma once

#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/byte_io.h"
#include "core/import/import_failure.h"
#include "core/math/vec.h"
#include "core/scene/value_ranges.h"

namespace qray {

constexpr int kMaxJsonDepth = 32;

struct JsonMember;
struct JsonValue {
  using Array = std::vector<JsonValue>;
  using Object = std::vector<JsonMember>;
  std::variant<std::monostate, bool, double, std::string, Array, Object> value;
};
struct JsonMember {
  std::string key;
  JsonValue value;
};

// `file` names the document in errors: "scene.json:12: ..." for syntax, a pointer for the rest.
JsonValue parse_json(std::span<const uint8_t> text, const std::string& file,
                     size_t max_values = std::numeric_limits<size_t>::max());

// A borrowed view of one value; the tree must outlive it.
class JsonNode {
 public:
  JsonNode(const JsonValue& value, std::string place) : value_(&value), place_(std::move(place)) {}

  const std::string& place() const { return place_; }
  [[noreturn]] void fail(const std::string& message, ErrorCode code = ErrorCode::kInvalid) const;
  // "expected <what>, got <this value>".
  [[noreturn]] void fail_expected(const std::string& what) const;

  bool is_number() const { return std::holds_alternative<double>(value_->value); }
  bool is_string() const { return std::holds_alternative<std::string>(value_->value); }
  bool is_array() const { return std::holds_alternative<JsonValue::Array>(value_->value); }

  bool boolean() const;
  float number() const;  // too large for a float: infinity, which no range has
  float number(float lo, float hi) const;
  int integer(int lo, int hi) const;
  const std::string& string() const;

  size_t size() const;  // of an array
  JsonNode at(size_t index) const;
  // Fails unless the array has exactly `count` numbers, none over `limit` in size.
  std::vector<float> numbers(size_t count, float limit = kMaxCoordinate) const;
  std::vector<double> doubles(size_t count, float limit) const;
  Vec3 vec3() const;
  Vec3 direction() const;  // of any length above 0
  Rgb number_or_rgb() const;

  // Members of an object; all fail when this is none.
  void only(const std::vector<std::string_view>& keys) const;
  bool has(std::string_view key) const { return find(key).has_value(); }
  std::optional<JsonNode> find(std::string_view key) const;
  JsonNode get(std::string_view key) const;
  std::vector<std::string> keys() const;

 private:
  const JsonValue::Object& object() const;
  const JsonValue* value_;
  std::string place_;
};

}  // namespace qray
