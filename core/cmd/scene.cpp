// qray scene check: whether a scene file would render, and what is in it.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/report.h"
#include "core/import/load_scene.h"

namespace qray::cmd {
namespace {

size_t emitting_shapes(const Scene& scene) {
  size_t count = 0;
  for (const Placement& placed : scene.placements())
    if (placed.mesh && scene.materials[placed.material.value].emits())
      count += placed.mesh->sphere ? 1 : placed.mesh->triangles.size();
  return count;
}

Status run(const std::string& name) {
  Result<std::filesystem::path> path = find_scene_path(name);
  if (!path) return path.error();
  Result<LoadedScene> loaded = load_scene(path.value());
  if (!loaded) return loaded.error();
  const Scene& scene = loaded.value().scene;
  std::printf("%s: good\n", path.value().c_str());
  std::printf("name        %s\n", scene.name.c_str());
  std::printf("picture     %d x %d, paths to depth %d\n", scene.width, scene.height,
              scene.max_depth);
  const Vec3 from = scene.camera.position, to = scene.camera.target;
  std::printf("camera      %s, at %g,%g,%g, target %g,%g,%g\n",
              std::string(name_of(scene.camera.projection)).c_str(), from.x, from.y, from.z, to.x,
              to.y, to.z);
  if (scene.motion_seconds > 0)
    std::printf("moves for %g s: %s\n", scene.motion_seconds,
                scene.moves_surfaces ? "surfaces or lights" : "cameras alone");
  for (const NamedCamera& own : scene.cameras)
    std::printf("camera      '%s', at %g,%g,%g, target %g,%g,%g\n", own.name.c_str(),
                own.camera.position.x, own.camera.position.y, own.camera.position.z,
                own.camera.target.x, own.camera.target.y, own.camera.target.z);
  std::printf("meshes      %zu, %zu triangles (%zu without area left out), %zu spheres\n",
              scene.meshes.size(), scene.triangle_count(), loaded.value().dropped_triangles,
              scene.sphere_count());
  if (!scene.instances.empty())
    std::printf("instances   %zu, %zu triangles in all\n", scene.instances.size(),
                scene.placed_triangle_count());
  std::printf("materials   %zu, %zu textures\n", scene.materials.size(), scene.textures.size());
  std::printf("lights      %zu emitting triangles and spheres, %zu without an extent, %s\n",
              emitting_shapes(scene), scene.lights.size(),
              !scene.environment.present()      ? "no sky"
              : scene.environment.image.empty() ? "a constant sky"
                                                : "a picture of the sky");
  std::printf("hash        %s\n", loaded.value().hash.whole().hex().c_str());
  for (const std::string& warning : loaded.value().warnings)
    std::printf("warning     %s\n", warning.c_str());
  return {};
}

}  // namespace

void add_scene(CLI::App& app, int& exit_code) {
  auto name = std::make_shared<std::string>();
  CLI::App* scene = app.add_subcommand("scene", "scene files");
  scene->require_subcommand(1);
  CLI::App* check = scene->add_subcommand("check", "load and validate a scene, and count it");
  check->add_option("scene", *name, "an included scene's name, a folder, or a file")->required();
  check->callback([name, &exit_code] {
    if (Status s = run(*name); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
