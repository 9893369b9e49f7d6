// Strict reading of requests: every field that is wrong is reported, by pointer. What the readers
// of requests in this folder share; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "proto/messages.h"

namespace qray::proto {

using Json = nlohmann::json;

// The parser and the tree's destructor recurse or grow with depth, so it is bounded beforehand.
inline bool deeper_than(std::string_view text, int limit) {
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

inline Problem problem(int status, std::string title, std::string detail) {
  return {status, std::move(title), std::move(detail), {}};
}

// A tree, or why not. Names given twice are an error: readers disagree on which one counts.
inline std::variant<Json, Problem> parse_tree(std::string_view text, const RequestLimits& limits) {
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

// A short form of what came, for messages. Text is cut; the reply's writer repairs cut UTF-8.
inline std::string shown(const Json& value) {
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

  const Json* find(std::string_view name) {
    known_.emplace(name);
    const auto it = object_.find(std::string(name));
    return it == object_.end() ? nullptr : &*it;
  }
  void wrong(std::string_view name, std::string detail) {
    errors_.push_back({pointer_ + "/" + std::string(name), std::move(detail)});
  }

  template <class T, class Out>
  void integer(std::string_view name, T least, T most, Out& out) {
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
  void number(std::string_view name, double least, double most, Out& out,
              bool above_least = false) {
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

  template <class Out>
  void boolean(std::string_view name, Out& out) {
    const Json* value = find(name);
    if (!value) return;
    if (value->is_boolean()) {
      out = value->get<bool>();
    } else {
      wrong(name, "expected true or false, got " + shown(*value));
    }
  }

  const std::string* string(std::string_view name) {
    const Json* value = find(name);
    if (!value) return nullptr;
    if (value->is_string()) return value->get_ptr<const std::string*>();
    wrong(name, "expected text, got " + shown(*value));
    return nullptr;
  }

  void one_of(std::string_view name, std::initializer_list<std::string_view> names,
              std::string& out) {
    const std::string* value = string(name);
    if (!value) return;
    if (std::find(names.begin(), names.end(), *value) != names.end()) {
      out = *value;
      return;
    }
    std::string known;
    for (std::string_view n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    wrong(name, "expected one of " + known + ", got " + shown(*value));
  }

  template <class Out>
  void vec3(std::string_view name, Out& out) {
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

}  // namespace qray::proto
