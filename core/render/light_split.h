// Into which layers of a film light goes: by how often it was scattered, and by the group of the
// light that it comes from. Pure functions; a split is immutable.
#pragma once

#include <string>
#include <vector>

#include "core/film/film.h"
#include "core/scene/scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// Lights are numbered as LightSample::source: meshes and instances by Hit::mesh, then lights
// without an extent as the scene lists them, then the environment.
inline uint32_t source_of_punctual(const Scene& scene, size_t light) {
  return static_cast<uint32_t>(scene.meshes.size() + scene.instances.size() + light);
}
inline uint32_t source_of_environment(const Scene& scene) {
  return source_of_punctual(scene, scene.lights.size());
}

struct LightSplit {
  FilmLayers layers;
  std::vector<std::string> groups;       // names, by number
  std::vector<uint8_t> group_of_source;  // empty: no groups
};

// What the settings ask for. kInvalid: the scene has more groups than kMaxLightGroups.
Result<LightSplit> light_split(const Scene& scene, const RenderSettings& settings);
// pre: that succeeds.
inline FilmLayers film_layers(const Scene& scene, const RenderSettings& settings) {
  return light_split(scene, settings).value().layers;
}

}  // namespace qray
