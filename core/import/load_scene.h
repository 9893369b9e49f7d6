// File -> Scene, validated. The format follows the extension: .json (docs/scene_format.md), .xml
// (Mitsuba's, docs/mitsuba.md), .gltf and .glb (docs/gltf.md), .obj (with its MTL; camera and size
// are chosen to show it all), .ply (one grey diffuse mesh under a constant sky). Paths in a file
// are relative to it.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/import/load_watch.h"
#include "core/scene/scene.h"
#include "core/scene/validate.h"

namespace qray {

struct LoadedScene {
  Scene scene;
  SceneHash hash;
  size_t dropped_triangles = 0;
  std::vector<std::string> warnings;  // things understood and left out, with their place
};

struct LoadOptions {
  SceneLimits limits;
  bool strict = false;  // the first thing that would be drawn otherwise than the file says fails
  LoadWatch watch{};    // may be empty
  // The scene as it is after so long, where its file says how it moves; none: at rest.
  std::optional<double> seconds{};
};

Result<LoadedScene> load_scene(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace qray
