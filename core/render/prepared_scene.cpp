#include "core/render/prepared_scene.h"

#include <algorithm>
#include <cmath>

#include "core/base/clock.h"

namespace qray {

namespace {

// A few units in the last place of the largest coordinate: what a hit on the largest triangle can
// be off by.
float ray_epsilon(const Bounds3& bounds) {
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis])});
  return largest * 0x1p-21f;
}

MeshShading mesh_shading(const PreparedScene& prepared, const Mesh& mesh) {
  const Material& material = prepared.scene.materials[mesh.material.value];
  MeshShading m;
  m.mesh = &mesh;
  m.material = &material;
  m.bsdf = prepared.bsdfs[mesh.material.value].get();
  m.constant = {material.reflectance.value, material.roughness.value};
  m.kind = m.bsdf->kind();
  m.emits = material.emits();
  m.textured = material.reflectance.texture.valid() || material.roughness.texture.valid();
  m.interpolated = !mesh.normals.empty() || (m.textured && !mesh.uvs.empty());
  return m;
}

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
  prepared->ray_epsilon = ray_epsilon(prepared->bounds);
  Result<std::unique_ptr<EmbreeScene>> accel = EmbreeScene::build(scene, build_threads);
  if (!accel.ok()) return accel.error();
  prepared->accel = std::move(accel).value();
  for (const Material& material : scene.materials) prepared->bsdfs.push_back(make_bsdf(material));
  for (const Texture& texture : scene.textures) {
    Result<int> handle = prepared->textures.open(texture.path, texture.srgb, texture.wrap_u);
    if (!handle.ok()) return handle.error();
    prepared->texture_handles.push_back(handle.value());
  }
  for (const Mesh& mesh : scene.meshes) prepared->meshes.push_back(mesh_shading(*prepared, mesh));
  prepared->lights.build(scene, prepared->bounds);
  return prepared;
}

}  // namespace

ShadingPoint PreparedScene::textured_point(const MeshShading& mesh, Vec2 uv) const {
  ShadingPoint sp = mesh.constant;
  const auto lookup = [&](TextureId id) { return textures.lookup(texture_handles[id.value], uv); };
  const TextureId reflectance = mesh.material->reflectance.texture;
  const TextureId roughness = mesh.material->roughness.texture;
  if (reflectance.valid()) sp.reflectance *= lookup(reflectance);
  if (roughness.valid()) sp.roughness *= lookup(roughness).r;
  return sp;
}

GuideSetup PreparedScene::guide_setup(const RenderSettings& settings) const {
  return {bounds, lights.brightest(), settings.max_table_bytes, settings.huang, settings.adaptive};
}

Result<std::shared_ptr<const PreparedScene>> prepare_scene(LoadedScene loaded, int build_threads) {
  Result<std::shared_ptr<PreparedScene>> prepared = prepare(std::move(loaded), build_threads);
  if (!prepared.ok()) return prepared.error();
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

Result<std::shared_ptr<const PreparedScene>> load_and_prepare_scene(
    const std::filesystem::path& path, int build_threads, const SceneLimits& limits, bool strict) {
  const SteadyClock clock;
  const double start = clock.seconds();
  Result<LoadedScene> loaded = load_scene(path, limits, strict);
  if (!loaded.ok()) return loaded.error();
  Result<std::shared_ptr<PreparedScene>> prepared =
      prepare(std::move(loaded).value(), build_threads);
  if (!prepared.ok()) return prepared.error();
  prepared.value()->seconds = clock.seconds() - start;
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

}  // namespace qray
