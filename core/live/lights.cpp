#include "core/live/lights.h"

#include "core/base/check.h"
#include "core/scene/scene_hash.h"

namespace qray {
namespace {

// Calls body(name, colour) for each light.
template <class SceneType, class Body>
void for_each_light(SceneType& scene, Body body) {
  for (auto& material : scene.materials)
    if (material.emits()) body(material.name, material.emission.value);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    static constexpr const char* kNames[] = {"point light ", "spot light ", "directional light "};
    auto& light = scene.lights[i];
    body(kNames[static_cast<size_t>(light.kind)] + std::to_string(i), light.intensity);
  }
  if (scene.environment.present()) body(std::string("environment"), scene.environment.radiance);
}

}  // namespace

std::vector<std::string> light_names(const Scene& scene) {
  std::vector<std::string> names;
  for_each_light(scene, [&](const std::string& name, const Rgb&) { names.push_back(name); });
  return names;
}

Result<std::shared_ptr<const PreparedScene>> with_lights(
    const std::shared_ptr<const PreparedScene>& scene, std::span<const float> factors) {
  Scene changed = scene->scene;
  QRAY_CHECK(factors.size() == light_names(changed).size());
  std::vector<Rgb*> colours;
  for_each_light(changed, [&](const std::string&, Rgb& colour) { colours.push_back(&colour); });
  for (size_t i = 0; i < colours.size(); ++i) *colours[i] *= factors[i];
  const Result<SceneHash> hash = hash_other_lights(changed, scene->hash);
  if (!hash.ok()) return hash.error();
  return prepare_same_surfaces(std::move(changed), hash.value(), scene);
}

}  // namespace qray
