// Small scenes made in code, for tests that need light but no files.
#pragma once

#include <memory>

#include "core/render/prepared_scene.h"
#include "core/scene/scene_hash.h"
#include "core/scene/validate.h"

namespace qray::test {

inline MaterialId add_material(Scene& scene, Rgb reflectance, Rgb emission = {}) {
  Material m;
  m.name = "m" + std::to_string(scene.materials.size());
  m.reflectance.value = reflectance;
  m.emission.value = emission;
  scene.materials.push_back(m);
  return MaterialId(static_cast<uint32_t>(scene.materials.size() - 1));
}

// A parallelogram whose front is on the side of cross(edge1, edge2).
inline void add_quad(Scene& scene, MaterialId material, Vec3 origin, Vec3 edge1, Vec3 edge2) {
  Mesh mesh;
  mesh.positions = {origin, origin + edge1, origin + edge1 + edge2, origin + edge2};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  scene.meshes.push_back(mesh);
}

// The six sides of a box, fronts to the inside or the outside.
inline void add_box(Scene& scene, MaterialId material, Vec3 lo, Vec3 hi, bool inward) {
  const Vec3 d = hi - lo, x{d.x, 0, 0}, y{0, d.y, 0}, z{0, 0, d.z};
  const auto side = [&](Vec3 origin, Vec3 a, Vec3 b) {
    if (inward) std::swap(a, b);
    add_quad(scene, material, origin, a, b);
  };
  side(lo, y, x);
  side(lo + z, x, y);
  side(lo, z, y);
  side(lo + x, y, z);
  side(lo, x, z);
  side(lo + y, z, x);
}

// A closed white 2 m room with a block in it. The light is a panel under the ceiling that shines
// down, or, shaded, a panel above a screen that shines up, so that all light is indirect.
inline Scene room(bool shaded = false) {
  Scene scene;
  scene.name = "room";
  const MaterialId white = add_material(scene, Rgb{0.7f});
  const MaterialId red = add_material(scene, {0.6f, 0.1f, 0.1f});
  const MaterialId light = add_material(scene, Rgb{0.0f}, Rgb{20.0f, 18.0f, 14.0f});
  add_box(scene, white, {-1, 0, -1}, {1, 2, 1}, true);
  add_box(scene, red, {0.1f, 0, -0.6f}, {0.6f, 0.9f, -0.1f}, false);
  if (shaded) {
    add_box(scene, white, {-0.4f, 1.6f, -0.4f}, {0.4f, 1.65f, 0.4f}, false);
    add_quad(scene, light, {-0.2f, 1.7f, -0.2f}, {0, 0, 0.4f}, {0.4f, 0, 0});
  } else {
    add_quad(scene, light, {-0.25f, 1.98f, -0.25f}, {0.5f, 0, 0}, {0, 0, 0.5f});
  }
  scene.camera.position = {0, 1, 0.95f};
  scene.camera.target = {0, 0.9f, 0};
  scene.camera.vertical_fov_deg = 70;
  scene.width = scene.height = 64;
  return scene;
}

// x, y, z times `scale`, then `offset` metres further: the camera too.
inline void place(Scene& scene, float scale, Vec3 offset) {
  for (Mesh& mesh : scene.meshes)
    for (Vec3& p : mesh.positions) p = p * scale + offset;
  scene.camera.position = scene.camera.position * scale + offset;
  scene.camera.target = scene.camera.target * scale + offset;
}

inline void scale_emission(Scene& scene, float scale) {
  for (Material& m : scene.materials) m.emission.value *= scale;
  scene.environment.radiance *= scale;
}

inline std::shared_ptr<const PreparedScene> prepare(Scene scene) {
  Result<ValidateReport> report = validate(scene);
  QRAY_CHECK(report.ok());
  Result<SceneHash> hash = hash_scene(scene);
  QRAY_CHECK(hash.ok());
  Result<std::shared_ptr<PreparedScene>> prepared =
      prepare_scene(std::move(scene), hash.value(), 1);
  QRAY_CHECK(prepared.ok());
  return prepared.value();
}

}  // namespace qray::test
