#include "core/render/light_mix.h"

#include <charconv>
#include <map>

#include "core/base/check.h"
#include "core/scene/scene_hash.h"

namespace qray {
namespace {

// Calls body(part) for each part of the text between separators.
template <class Body>
void for_each_part(std::string_view text, char separator, Body body) {
  for (;;) {
    const size_t end = std::min(text.find(separator), text.size());
    body(text.substr(0, end));
    if (end == text.size()) return;
    text.remove_prefix(end + 1);
  }
}

std::optional<Rgb> factor_of(std::string_view text) {
  std::vector<float> numbers;
  bool good = true;
  for_each_part(text, ',', [&](std::string_view part) {
    float v = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), v);
    good &=
        error == std::errc() && end == part.data() + part.size() && v >= 0 && v <= kMostMixFactor;
    numbers.push_back(v);
  });
  if (!good || (numbers.size() != 1 && numbers.size() != 3)) return {};
  return numbers.size() == 1 ? Rgb{numbers[0]} : Rgb{numbers[0], numbers[1], numbers[2]};
}

// Each emitting mesh has a material for its factor: one material may light several groups.
void light_meshes(Scene& scene, const LightSplit& split, std::span<const Rgb> factors) {
  const size_t meshes = scene.meshes.size();
  std::map<std::pair<uint32_t, uint8_t>, MaterialId> made;
  const std::vector<Placement> placements = scene.placements();
  for (size_t i = 0; i < placements.size(); ++i) {
    const Placement& placement = placements[i];
    if (!placement.mesh || !scene.materials[placement.material.value].emits()) continue;
    const uint8_t group = split.group_of_source[i];
    const auto [at, is_new] = made.try_emplace({placement.material.value, group});
    if (is_new) {
      at->second = MaterialId(static_cast<uint32_t>(scene.materials.size()));
      Material material = scene.materials[placement.material.value];
      material.emission.value *= factors[group];
      scene.materials.push_back(std::move(material));
    }
    (i < meshes ? scene.meshes[i].material : scene.instances[i - meshes].material) = at->second;
  }
}

}  // namespace

Result<std::vector<Rgb>> parse_mix(std::string_view text, size_t groups) {
  std::vector<Rgb> factors;
  bool good = true;
  for_each_part(text, ';', [&](std::string_view part) {
    const std::optional<Rgb> factor = factor_of(part);
    good &= factor.has_value();
    factors.push_back(factor.value_or(Rgb{}));
  });
  if (good && factors.size() == groups) return factors;
  return Error{
      ErrorCode::kInvalid,
      "expected " + std::to_string(groups) +
          " factors with semicolons between, each a number from 0 on or three with commas, "
          "got '" +
          std::string(text) + "'",
      "/mix"};
}

Image mixed(std::span<const Image> groups, std::span<const Rgb> factors) {
  QRAY_CHECK(!groups.empty() && groups.size() == factors.size());
  Image sum(groups.front().width(), groups.front().height(), 3);
  for (size_t g = 0; g < groups.size(); ++g)
    for (int y = 0; y < sum.height(); ++y)
      for (int x = 0; x < sum.width(); ++x)
        sum.set_rgb(x, y, sum.rgb(x, y) + groups[g].rgb(x, y) * factors[g]);
  return sum;
}

Result<std::shared_ptr<const PreparedScene>> lit_by_mix(
    const std::shared_ptr<const PreparedScene>& scene, const RenderSettings& settings) {
  if (settings.mix.empty()) return scene;
  const Result<LightSplit> split = light_split(scene->scene, settings);
  if (!split.ok()) return split.error();
  if (split.value().groups.empty())
    return Error{ErrorCode::kInvalid, "expected light_groups beside it, and lights", "/mix"};
  const Result<std::vector<Rgb>> factors = parse_mix(settings.mix, split.value().groups.size());
  if (!factors.ok()) return factors.error();
  const auto factor = [&](uint32_t source) {
    return factors.value()[split.value().group_of_source[source]];
  };
  Scene changed = scene->scene;
  light_meshes(changed, split.value(), factors.value());
  for (size_t i = 0; i < changed.lights.size(); ++i)
    changed.lights[i].intensity *= factor(source_of_punctual(scene->scene, i));
  changed.environment.radiance *= factor(source_of_environment(scene->scene));
  const Result<SceneHash> hash = hash_other_lights(changed, scene->hash);
  if (!hash.ok()) return hash.error();
  return prepare_same_surfaces(std::move(changed), hash.value(), scene);
}

}  // namespace qray
