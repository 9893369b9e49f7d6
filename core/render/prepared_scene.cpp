#include "core/render/prepared_scene.h"

#include <algorithm>
#include <cmath>

#include "core/base/clock.h"

namespace qray {

namespace {

Result<std::shared_ptr<PreparedScene>> prepare(LoadedScene loaded, int build_threads) {
  auto prepared = std::make_shared<PreparedScene>();
  prepared->scene = std::move(loaded.scene);
  prepared->hash = loaded.hash;
  prepared->warnings = std::move(loaded.warnings);
  if (loaded.dropped_triangles > 0) {
    prepared->warnings.push_back(std::to_string(loaded.dropped_triangles) +
                                 " triangles without area were left out");
  }
  const Scene& scene = prepared->scene;
  prepared->bounds = scene.bounds();
  prepared->ray_epsilon =
      0x1p-21f *
      max_component({std::max(std::abs(prepared->bounds.lo.x), std::abs(prepared->bounds.hi.x)),
                     std::max(std::abs(prepared->bounds.lo.y), std::abs(prepared->bounds.hi.y)),
                     std::max(std::abs(prepared->bounds.lo.z), std::abs(prepared->bounds.hi.z))});
  Result<std::unique_ptr<EmbreeScene>> accel = EmbreeScene::build(scene, build_threads);
  if (!accel.ok()) return accel.error();
  prepared->accel = std::move(accel).value();
  for (const Material& material : scene.materials) prepared->bsdfs.push_back(make_bsdf(material));
  for (const Texture& texture : scene.textures) {
    Result<int> handle = prepared->textures.open(texture.path, texture.srgb, texture.wrap);
    if (!handle.ok()) return handle.error();
    prepared->texture_handles.push_back(handle.value());
  }
  prepared->lights.build(scene, prepared->bounds);
  return prepared;
}

}  // namespace

ShadingPoint PreparedScene::shading_point(const Material& material, Vec2 uv) const {
  ShadingPoint sp{material.reflectance.value, material.roughness.value};
  const auto lookup = [&](TextureId id) { return textures.lookup(texture_handles[id.value], uv); };
  if (material.reflectance.texture.valid()) sp.reflectance *= lookup(material.reflectance.texture);
  if (material.roughness.texture.valid()) sp.roughness *= lookup(material.roughness.texture).r;
  return sp;
}

Result<std::shared_ptr<const PreparedScene>> prepare_scene(LoadedScene loaded, int build_threads) {
  Result<std::shared_ptr<PreparedScene>> prepared = prepare(std::move(loaded), build_threads);
  if (!prepared.ok()) return prepared.error();
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

Result<std::shared_ptr<const PreparedScene>> load_and_prepare_scene(
    const std::filesystem::path& path, int build_threads, const SceneLimits& limits) {
  const SteadyClock clock;
  const double start = clock.seconds();
  Result<LoadedScene> loaded = load_scene(path, limits);
  if (!loaded.ok()) return loaded.error();
  Result<std::shared_ptr<PreparedScene>> prepared =
      prepare(std::move(loaded).value(), build_threads);
  if (!prepared.ok()) return prepared.error();
  prepared.value()->seconds = clock.seconds() - start;
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

}  // namespace qray
