#include "core/scene/scene.h"

#include <algorithm>

namespace qray {

void Scene::add_camera(std::string name, const Camera& view,
                       std::shared_ptr<const CameraPath> path) {
  if (name.empty()) name = "camera-" + std::to_string(cameras.size() + 1);
  std::string free = name;
  for (int number = 2; find_camera(free); ++number) free = name + "-" + std::to_string(number);
  cameras.push_back({std::move(free), view, std::move(path)});
}

const NamedCamera* Scene::find_camera(std::string_view name) const {
  const auto found = std::find_if(cameras.begin(), cameras.end(),
                                  [&](const NamedCamera& own) { return own.name == name; });
  return found == cameras.end() ? nullptr : &*found;
}

std::vector<Placement> Scene::placements() const {
  std::vector<Placement> all;
  all.reserve(meshes.size() + instances.size());
  for (const Mesh& mesh : meshes) all.push_back({&mesh, nullptr, mesh.material});
  for (const Instance& instance : instances) {
    all[instance.mesh.value].mesh = nullptr;
    const Mesh& mesh = meshes[instance.mesh.value];
    all.push_back(
        {&mesh, &instance.to_world, instance.material.valid() ? instance.material : mesh.material});
  }
  return all;
}

size_t Scene::sphere_count() const {
  return static_cast<size_t>(
      std::ranges::count_if(meshes, [](const Mesh& mesh) { return mesh.sphere.has_value(); }));
}

size_t Scene::triangle_count() const {
  size_t count = 0;
  for (const Mesh& mesh : meshes) count += mesh.triangles.size();
  return count;
}

size_t Scene::placed_triangle_count() const {
  size_t count = 0;
  for (const Placement& placed : placements())
    if (placed.mesh) count += placed.mesh->triangles.size();
  return count;
}

Bounds3 Scene::bounds() const {
  std::vector<Bounds3> boxes(meshes.size());
  for (size_t m = 0; m < meshes.size(); ++m) {
    for (const auto& tri : meshes[m].triangles)
      for (const uint32_t v : tri) boxes[m].add(meshes[m].positions[v]);
    if (const auto& sphere = meshes[m].sphere) boxes[m] = sphere->bounds();
  }
  Bounds3 all;
  for (const Placement& placed : placements()) {
    if (!placed.mesh) continue;
    const Bounds3& box = boxes[static_cast<size_t>(placed.mesh - meshes.data())];
    if (box.empty()) continue;
    for (int corner = 0; corner < 8; ++corner) {
      all.add(placed.at({corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                         corner & 4 ? box.hi.z : box.lo.z}));
    }
  }
  return all;
}

}  // namespace qray
