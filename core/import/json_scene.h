// The JSON scene format, docs/scene_format.md. Throws ImportFailure. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/import/imported_scene.h"
#include "core/import/json_tree.h"
#include "core/import/load_watch.h"
#include "core/scene/validate.h"

namespace qray {

// As its motions have it after `seconds`; none: at rest.
ImportedScene read_json_scene(const std::filesystem::path& path, const SceneLimits& limits,
                              const LoadWatch& watch = {},
                              std::optional<double> seconds = std::nullopt);

// The parts, one file each.
using TextureNames = std::map<std::string, TextureId, std::less<>>;
using MaterialNames = std::map<std::string, MaterialId, std::less<>>;
Material read_material(const JsonNode& node, const TextureNames& textures,
                       const MaterialNames& earlier);
PunctualLight read_light(const JsonNode& node);
std::string read_light_group(const JsonNode& node);  // its "light_group"; empty: none
// One shape with its "transform" and "flip" applied, material unset; "file" is left to the caller.
Mesh read_shape(const JsonNode& node, const SceneLimits& limits);
void apply_placement(const JsonNode& node, Mesh& mesh);
Transform read_placement(const JsonNode& node);  // its "transform", or none

}  // namespace qray
