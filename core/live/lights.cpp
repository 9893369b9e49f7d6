#include "core/live/lights.h"

#include "core/base/check.h"
#include "core/render/light_split.h"
#include "core/scene/scene_hash.h"
#include "core/settings/field.h"

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

Result<std::string> mix_of_lights(const Scene& scene, std::span<const double> factors) {
  RenderSettings settings;
  settings.light_groups = LightGrouping::kMaterial;
  const Result<LightSplit> split = light_split(scene, settings);
  if (!split.ok()) return split.error();
  size_t light = 0;
  std::vector<double> of_material(scene.materials.size(), 1);
  for (size_t i = 0; i < scene.materials.size(); ++i)
    if (scene.materials[i].emits()) of_material[i] = factors[light++];
  std::vector<double> of_group(split.value().groups.size(), 1);
  const auto put = [&](uint32_t source, double factor) {
    of_group[split.value().group_of_source[source]] = factor;
  };
  const std::vector<Placement> placements = scene.placements();
  for (uint32_t i = 0; i < placements.size(); ++i) {
    const MaterialId material = placements[i].material;
    if (placements[i].mesh && scene.materials[material.value].emits())
      put(i, of_material[material.value]);
  }
  for (size_t i = 0; i < scene.lights.size(); ++i, ++light)
    if (scene.lights[i].emits()) put(source_of_punctual(scene, i), factors[light]);
  if (scene.environment.present()) put(source_of_environment(scene), factors[light]);
  std::string mix;
  for (const double factor : of_group) mix += (mix.empty() ? "" : ";") + number_text(factor);
  return mix;
}

}  // namespace qray
