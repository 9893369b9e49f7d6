#include "core/render/prepared_scene.h"

#include <algorithm>
#include <cmath>

#include "core/base/clock.h"

namespace qray {

namespace {

float largest_coordinate(const Bounds3& box) {
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
  return largest;
}

// A few units in the last place of the largest coordinate: what a hit on the largest triangle can
// be off by. An instance is hit in its mesh's space, whose coordinates may be larger.
float ray_epsilon(const PreparedScene& prepared) {
  float largest = largest_coordinate(prepared.bounds);
  const Scene& scene = prepared.scene;
  std::vector<float> of_mesh(scene.instances.empty() ? 0 : scene.meshes.size(), 0.0f);
  for (size_t m = 0; m < of_mesh.size(); ++m) {
    Bounds3 box;
    for (const Vec3 p : scene.meshes[m].positions) box.add(p);
    of_mesh[m] = largest_coordinate(box);
  }
  for (const Instance& instance : scene.instances) {
    double stretch = 0;
    for (const auto& row : instance.to_world.rows)
      stretch = std::max(stretch, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
    largest = std::max(largest, of_mesh[instance.mesh.value] * static_cast<float>(stretch));
  }
  return largest * 0x1p-21f;
}

MeshShading mesh_shading(const PreparedScene& prepared, const Placement& placed) {
  MeshShading m;
  if (!placed.mesh) return m;
  const Material& material = prepared.scene.materials[placed.material.value];
  m.mesh = placed.mesh;
  m.material = &material;
  m.bsdf = prepared.bsdfs[placed.material.value].get();
  m.constant = {material.reflectance.value, material.roughness.value};
  m.kind = m.bsdf->kind();
  m.emits = material.emits();
  m.textured = material.reflectance.texture.valid() || material.roughness.texture.valid();
  m.interpolated = !placed.mesh->normals.empty() || (m.textured && !placed.mesh->uvs.empty());
  if (placed.to_world) m.normals_to_world = placed.to_world->normals();
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
  prepared->ray_epsilon = ray_epsilon(*prepared);
  Result<std::unique_ptr<EmbreeScene>> accel = EmbreeScene::build(scene, build_threads);
  if (!accel.ok()) return accel.error();
  prepared->accel = std::move(accel).value();
  for (const Material& material : scene.materials) prepared->bsdfs.push_back(make_bsdf(material));
  for (const Texture& texture : scene.textures) {
    Result<int> handle = prepared->textures.open(texture.path, texture.srgb, texture.wrap_u);
    if (!handle.ok()) return handle.error();
    prepared->texture_handles.push_back(handle.value());
  }
  for (const Placement& placed : scene.placements())
    prepared->meshes.push_back(mesh_shading(*prepared, placed));
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
