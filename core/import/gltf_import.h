// What the parts of the glTF importer share. One import, one thread.
#pragma once

#include "core/import/gltf_document.h"
#include "core/import/imported_scene.h"
#include "core/import/load_watch.h"
#include "core/scene/validate.h"

namespace qray {

struct GltfImport {
  GltfDocument& document;
  const SceneLimits& limits;
  const LoadWatch& watch;
  ImportedScene out;
  size_t sparse_left = 50'000'000;  // that accessors may still change: many may share a long list

  // Something is drawn otherwise than the file says.
  void warn(const JsonNode& node, const std::string& text);
  // Extensions of `node` beyond those named are drawn as if they were not there: warns of each.
  void expect_extensions(const JsonNode& node, std::initializer_list<std::string_view> known);
};

// The extension `name` of `node`, if it has it.
std::optional<JsonNode> find_extension(const JsonNode& node, std::string_view name);

}  // namespace qray
