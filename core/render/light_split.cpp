#include "core/render/light_split.h"

#include <unordered_map>

namespace qray {
namespace {

constexpr const char* kRest = "rest";  // of lights that name no group

class Groups {
 public:
  explicit Groups(const Scene& scene) : of_source_(source_of_environment(scene) + 1, 0) {}

  void put(uint32_t source, const std::string& name) {
    const auto [number, is_new] = numbers_.try_emplace(name, names_.size());
    of_source_[source] = number->second;
    if (is_new) names_.push_back(name);
  }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<size_t>& of_source() const { return of_source_; }

 private:
  std::vector<std::string> names_;
  std::unordered_map<std::string, size_t> numbers_;  // by name: there may be as many as meshes
  std::vector<size_t> of_source_;
};

std::string numbered(const char* kind, size_t number) {
  return kind + std::string(" ") + std::to_string(number);
}

// What a mesh or an instance is called; without a name, by its number.
std::string name_of(const Scene& scene, size_t placement) {
  const bool placed_again = placement >= scene.meshes.size();
  const size_t mesh =
      placed_again ? scene.instances[placement - scene.meshes.size()].mesh.value : placement;
  const std::string& name = scene.meshes[mesh].name;
  return name.empty() ? numbered("mesh", mesh) : name;
}

std::string group_of_mesh(const Scene& scene, size_t placement, const Material& material,
                          LightGrouping by) {
  switch (by) {
    case LightGrouping::kScene:
      return material.light_group.empty() ? kRest : material.light_group;
    case LightGrouping::kMaterial:
      return material.name;
    case LightGrouping::kName:
      return name_of(scene, placement);
    default:
      return numbered(name_of(scene, placement).c_str(), placement);
  }
}

std::string group_of(const std::string& own, LightGrouping by, const std::string& name) {
  return by != LightGrouping::kScene ? name : own.empty() ? kRest : own;
}

}  // namespace

Result<LightSplit> light_split(const Scene& scene, const RenderSettings& settings) {
  LightSplit split;
  split.layers.bounces = settings.bounce_layers();
  const LightGrouping by = settings.light_groups;
  if (by == LightGrouping::kNone) return split;
  Groups groups(scene);
  const std::vector<Placement> placements = scene.placements();
  for (size_t i = 0; i < placements.size(); ++i) {
    const Material& material = scene.materials[placements[i].material.value];
    if (placements[i].mesh && material.emits())
      groups.put(static_cast<uint32_t>(i), group_of_mesh(scene, i, material, by));
  }
  for (size_t i = 0; i < scene.lights.size(); ++i)
    if (scene.lights[i].emits())
      groups.put(source_of_punctual(scene, i),
                 group_of(scene.lights[i].light_group, by, numbered("light", i)));
  if (scene.environment.present())
    groups.put(source_of_environment(scene),
               group_of(scene.environment.light_group, by, "environment"));
  split.groups = groups.names();
  if (split.groups.size() > kMaxLightGroups) {
    return Error{ErrorCode::kInvalid,
                 "expected at most " + std::to_string(kMaxLightGroups) +
                     " groups of lights, but the scene has " + std::to_string(split.groups.size()),
                 "/light_groups"};
  }
  split.layers.groups = static_cast<int>(split.groups.size());
  for (const size_t group : groups.of_source())
    split.group_of_source.push_back(static_cast<uint8_t>(group));
  return split;
}

}  // namespace qray
