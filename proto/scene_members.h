// The members that requests of jobs and of live sessions share: what is rendered, how, and from
// what was learned. Any thread.
#pragma once

#include "proto/request_reader.h"

namespace qray::proto {

inline void read_scene(ObjectReader& in, std::string& scene) {
  if (const std::string* name = in.string("scene")) {
    scene = *name;
    if (!is_name(scene)) in.wrong("scene", "expected a scene's name: 1..64 of a-z, 0-9 and -");
  } else if (!in.find("scene")) {
    in.wrong("scene", "expected a scene's name, got nothing");
  }
}

inline void read_method(ObjectReader& in, const RequestLimits& limits, std::string& method) {
  const std::string* name = in.string("method");
  if (!name) return;
  method = *name;
  const auto& known = limits.methods;
  if (known.empty() || std::find(known.begin(), known.end(), method) != known.end()) return;
  std::string names;
  for (const std::string& one : known) names += (names.empty() ? "" : ", ") + one;
  in.wrong("method", "expected one of " + names + ", got " + shown(*name));
}

inline void read_table(ObjectReader& in, std::string& table) {
  const std::string* name = in.string("table");
  if (!name) return;
  table = *name;
  if (table != "auto" && table != "none" && !is_id(table))
    in.wrong("table", "expected auto, none or a table's id (32 hex digits), got " + shown(*name));
}

inline void read_recover(ObjectReader& in, std::initializer_list<std::string_view> names,
                         std::string& recover) {
  const Json* value = in.find("recover");
  if (value && value->is_string() && is_id(value->get_ref<const std::string&>())) {
    recover = value->get<std::string>();
  } else {
    in.one_of("recover", names, recover, " or the id of weights (32 hex digits)");
  }
}

}  // namespace qray::proto
