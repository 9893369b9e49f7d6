// What must hold of a scene's file, whatever is in it.
#pragma once

#include "core/import/load_scene.h"
#include "core/scene/motion.h"
#include "tests/fuzz/fuzz.h"

namespace qray::fuzz {

// Small, so that time and memory stay bounded.
inline LoadOptions small_scenes() {
  LoadOptions options;
  options.limits.max_triangles = 20'000;
  options.limits.max_materials = 200;
  options.limits.max_lights = 200;
  options.limits.max_instances = 200;
  return options;
}

inline void expect_indices_in_range(const Mesh& mesh) {
  for (const auto& triangle : mesh.triangles)
    for (const uint32_t vertex : triangle) QRAY_CHECK(vertex < mesh.positions.size());
  QRAY_CHECK(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  QRAY_CHECK(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
}

// It fails and says why and where, or gives a scene that validate() has nothing to say about.
inline void expect_scene_or_error(const std::filesystem::path& path, const LoadOptions& options) {
  Result<LoadedScene> loaded = load_scene(path, options);
  if (!loaded.ok()) return expect_said_why(loaded.error());
  Scene& scene = loaded.value().scene;
  for (const Mesh& mesh : scene.meshes) expect_indices_in_range(mesh);
  const Result<ValidateReport> report = validate(scene, options.limits);
  QRAY_CHECK(report.ok());
  QRAY_CHECK(report.value().dropped_triangles == 0);
  if (options.seconds || scene.motion_seconds == 0) return;
  LoadOptions then = options;
  then.seconds = scene.motion_seconds / 3;
  for (const NamedCamera& camera : scene.cameras)
    if (camera.path) (void)camera.path->at(*then.seconds);
  expect_scene_or_error(path, then);
}
inline void expect_scene_or_error(const std::filesystem::path& path) {
  expect_scene_or_error(path, small_scenes());
}

}  // namespace qray::fuzz
