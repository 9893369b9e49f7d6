// A scene ready for rays: the data, its tree, its BSDFs, textures and lights. Immutable; shared by
// the jobs that render it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/accel/embree_scene.h"
#include "core/bsdf/bsdf.h"
#include "core/import/load_scene.h"
#include "core/render/light_pick.h"
#include "core/render/settings.h"
#include "core/scene/surface.h"

namespace qray {

// What a hit needs to know of its mesh or instance, side by side in memory.
struct MeshShading {
  const Mesh* mesh = nullptr;  // null: seen by its instances alone
  const Material* material = nullptr;
  const Bsdf* bsdf = nullptr;
  ShadingPoint constant;  // the material's parameters where no texture changes them
  BsdfKind kind = BsdfKind::kDiffuse;
  bool emits = false, textured = false, interpolated = false;
  std::optional<Mat3> normals_to_world;  // an instance's
};

struct PreparedScene {
  Scene scene;
  SceneHash hash;
  Bounds3 bounds;
  float ray_epsilon = 0;  // metres: rounding noise of coordinates on the largest triangles
  double seconds = 0;     // that loading and preparing took
  std::vector<std::string> warnings;
  std::unique_ptr<EmbreeScene> accel;
  std::vector<std::unique_ptr<Bsdf>> bsdfs;  // by MaterialId
  TextureCache textures;
  std::vector<int> texture_handles;  // by TextureId
  LightPick lights;

  std::vector<MeshShading> meshes;  // by Hit::mesh

  SurfacePoint surface_at(const Ray& ray, const Hit& hit) const {
    const Vec3 ng = normalize(hit.ng);
    SurfacePoint surface{ray.o + ray.d * hit.t, ng, ng, {}};
    const MeshShading& m = meshes[hit.mesh.value];
    if (m.interpolated) {
      interpolate_vertices(*m.mesh, m.normals_to_world ? &*m.normals_to_world : nullptr,
                           hit.triangle, hit.barycentric, surface);
    }
    return surface;
  }
  GuideSetup guide_setup(const RenderSettings& settings) const;
  // The material's parameters at uv, textures looked up.
  ShadingPoint shading_point(const MeshShading& mesh, Vec2 uv) const {
    return mesh.textured ? textured_point(mesh, uv) : mesh.constant;
  }

 private:
  ShadingPoint textured_point(const MeshShading& mesh, Vec2 uv) const;
};

Result<std::shared_ptr<const PreparedScene>> prepare_scene(LoadedScene loaded, int build_threads);
Result<std::shared_ptr<const PreparedScene>> load_and_prepare_scene(
    const std::filesystem::path& path, int build_threads, const SceneLimits& limits = {},
    bool strict = false);

}  // namespace qray
