// What every reader of a scene's format gives: the scene as its file says it, and what errors and
// warnings need to name the place. Plain data.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace qray {

inline constexpr size_t kMaxWarnings = 1000;  // of one scene

// Not validated yet.
struct ImportedScene {
  Scene scene;
  std::vector<std::string> warnings;  // things understood and left out, with their place
  void warn(const std::string& place, const std::string& text) {
    if (warnings.size() < kMaxWarnings) warnings.push_back(place + ": " + text);
  }
  // Where scene.meshes[i] was read from, as a pointer into the document: a file may hold several.
  std::vector<std::string> mesh_pointers;
  std::vector<std::string> instance_pointers;  // of scene.instances[i]
};

}  // namespace qray
