// A scene ready for rays: the data, its tree, its BSDFs, textures and lights. Immutable; shared by
// the jobs that render it.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/accel/embree_scene.h"
#include "core/base/task_pool.h"
#include "core/guide/guide_setup.h"
#include "core/render/bent_normal.h"
#include "core/render/light_pick.h"
#include "core/render/material_shading.h"
#include "core/render/material_textures.h"
#include "core/scene/surface.h"
#include "core/settings/render_settings.h"

namespace qray {

// What a hit needs to know of its mesh or instance, side by side in memory.
struct MeshShading : MaterialShading {
  const Mesh* mesh = nullptr;              // null: seen by its instances alone
  const Transform* to_world = nullptr;     // an instance's
  std::optional<Mat3> normals_to_world{};  // the same
  bool interpolated = false;
  const Sphere* sphere = nullptr;  // instead of triangles
  bool plain = false;              // Lambert's alone and the same everywhere, by the triangles

  bool has_uv() const { return sphere || !mesh->uvs.empty(); }
};

class CausticMap;

struct PreparedScene {
  PreparedScene();
  ~PreparedScene();

  Scene scene;
  SceneHash hash;
  Bounds3 bounds;
  float ray_epsilon = 0;  // metres: rounding noise of coordinates on the largest triangles
  double seconds = 0;     // that loading and preparing took; the loader's, as the warnings are
  std::vector<std::string> warnings;
  std::shared_ptr<const EmbreeScene> accel;
  std::vector<std::unique_ptr<Bsdf>> bsdfs;  // by MaterialId
  std::shared_ptr<const MaterialTextures> textures;
  LightPick lights;

  std::vector<MaterialShading> materials;  // by MaterialId
  std::vector<MeshShading> meshes;         // by Hit::mesh

  // Where mirrors and glass send light; null: no place is worth aiming there. Traced by the pool at
  // the first call. Any thread.
  const CausticMap* caustics(TaskPool& pool) const;

  // `ray_width`: metres that the ray stands for at the hit, across it.
  SurfacePoint surface_at(const Ray& ray, const Hit& hit, float ray_width = 0) const {
    const Vec3 ng = normalize(hit.ng);
    SurfacePoint surface{ray.o + ray.d * hit.t, ng, ng};
    complete(meshes[hit.mesh.value], hit, -ray.d, ray_width, surface);
    return surface;
  }
  // The surface has its place and the triangle's normal: adds what its mesh knows of it.
  void complete(const MeshShading& m, const Hit& hit, Vec3 wo, float ray_width,
                SurfacePoint& surface) const {
    if (m.sphere) {
      put_on_sphere(m, surface);
    } else if (m.interpolated) {
      interpolate_vertices(*m.mesh, hit.triangle, hit.barycentric, surface,
                           m.normals_to_world ? &*m.normals_to_world : nullptr);
    }
    if (ray_width > 0 && m.needs_uv()) {
      surface.uv.width = ray_width * uv_per_metre(m, hit.triangle, m.mesh->uvs);
      if (!m.mesh->second_uvs.empty())
        surface.uv.second_width = ray_width * uv_per_metre(m, hit.triangle, m.mesh->second_uvs);
    }
    if (m.bends) bend(m, hit, wo, surface);
  }
  // What is near the sphere, exactly there.
  static void put_on_sphere(const MeshShading& mesh, SurfacePoint& surface);
  // Turns the shading normal by the material's images, as seen from wo.
  void bend(const MaterialShading& material, const Hit& hit, Vec3 wo, SurfacePoint& surface) const;
  // What the material's BSDF calls local, about the unit normal n.
  Frame frame_at(const MaterialShading& material, const Hit& hit, Vec3 n, TexturePoint uv) const {
    return material.anisotropic ? turned_frame(material, hit, n, uv) : Frame(n);
  }
  Frame turned_frame(const MaterialShading& material, const Hit& hit, Vec3 n,
                     TexturePoint uv) const;
  static Vec3 scattering_normal(const MaterialShading& material, Vec3 wo,
                                const SurfacePoint& surface) {
    const bool shading_normal_usable = dot(wo, surface.ns) * dot(wo, surface.ng) > 0;
    return material.seen_whole     ? seen_normal(surface.ns, surface.ng, wo)
           : shading_normal_usable ? surface.ns
                                   : surface.ng;
  }
  // In which a path that comes from wo scatters: about the shading normal, if wo lies on the same
  // side of it as of the triangle, or can be made to.
  Frame scattering_frame(const MaterialShading& material, const Hit& hit, Vec3 wo,
                         const SurfacePoint& surface) const {
    return frame_at(material, hit, scattering_normal(material, wo, surface), surface.uv);
  }
  // Metres off the surface where rays may start after a hit at distance t: more than the rounding
  // noise of o + t d and of the largest triangle's coordinates.
  float ray_offset(Vec3 p, float t) const {
    const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), t});
    return std::max(largest * kRayOffset, ray_epsilon);
  }
  // Of a coat that has normals of its own, seen from wo. World space, unit.
  Vec3 coat_normal(const MaterialShading& material, const Hit& hit, Vec3 wo,
                   const SurfacePoint& surface) const;
  // The material itself, or the part of a blend that u in [0, 1) picks.
  const MaterialShading& resolve(const MaterialShading& material, TexturePoint uv, float u) const;
  // Radiance that a front emits; less where it is not opaque. Of a sphere, `barycentric` is uv.
  Rgb emission_at(MeshId mesh, uint32_t triangle, Vec2 barycentric) const;
  size_t size_bytes() const;  // of memory, about; grows by textures and caustics
  GuideSetup guide_setup(const RenderSettings& settings) const;
  // The material's parameters there, textures looked up: in `room`, or the material's own where
  // they are the same everywhere.
  const ShadingPoint& shading_point(const MaterialShading& material, const SurfacePoint& surface,
                                    ShadingPoint& room) const {
    if (!material.textured && !surface.color) return material.constant;
    room = material.textured ? textures->point(*material.material, surface.uv) : material.constant;
    if (surface.color) room.reflectance *= *surface.color;
    return room;
  }
  // How much of what arrives there the surface stops, in [0, 1]; of a blend its parts counted.
  float opacity(const MaterialShading& material, TexturePoint uv) const;
  // Of the triangle's edges the least: 0 where they have no uv. Of a sphere, at its equator.
  static float uv_per_metre(const MeshShading& mesh, uint32_t triangle,
                            const std::vector<Vec2>& uvs);
  // The triangle's, or of a sphere a unit of u and one of v. pre: has_uv().
  static TriangleEdges edges_at(const MeshShading& mesh, const Hit& hit);
  // Whether a ray passes a hit on a masked mesh: drawn by its bits, the same at every call.
  bool passes(const Ray& ray, const Hit& hit) const;
  // What of the light on its way along a ray passes a hit on a masked mesh or a pane.
  Rgb light_passed(const Ray& ray, const Hit& hit) const;
  // What goes straight on through a pane, by the normal of the triangle: of rays to lights and of
  // paths alike, so that both find the same light. World space; ng need not be unit.
  Rgb straight(Vec3 d, Vec3 ng, const Hit& hit) const;

 private:
  mutable std::once_flag caustics_once_;
  mutable std::unique_ptr<const CausticMap> caustics_;
  mutable std::atomic<size_t> caustics_bytes_ = 0;
};

// Called now and then while the tree is built with how much of it is done, [0, 1], by several
// threads at once. False: preparing ends with kCanceled. It may be empty.
using BuildWatch = std::function<bool(double fraction)>;

// pre: `scene` is validated (core/scene/validate.h), `hash` is its own. Not const, for the loader's
// fields alone.
Result<std::shared_ptr<PreparedScene>> prepare_scene(Scene scene, SceneHash hash, int build_threads,
                                                     const BuildWatch& watch = {});
// `scene` has the surfaces and images of `same`, whose tree both then share, and which lives as
// long: only what surfaces and lights emit may differ.
std::shared_ptr<const PreparedScene> prepare_same_surfaces(
    Scene scene, SceneHash hash, const std::shared_ptr<const PreparedScene>& same);

}  // namespace qray
