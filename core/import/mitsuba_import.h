// What the parts of the Mitsuba importer share. One import, one thread.
#pragma once

#include "core/import/imported_scene.h"
#include "core/import/load_watch.h"
#include "core/import/mitsuba_tree.h"
#include "core/import/mitsuba_values.h"
#include "core/scene/validate.h"

namespace qray {

struct MitsubaImport {
  const MitsubaDocument& document;
  const SceneLimits& limits;
  const LoadWatch& watch;
  ImportedScene out;

  // Something is drawn otherwise than the file says.
  void warn(const MitsubaNode& node, const std::string& text);
  // Parameters of a plugin beyond those named are drawn as if they were not there: warns of each.
  void expect_only(const MitsubaNode& plugin, std::initializer_list<std::string_view> known);
};

}  // namespace qray
