// Ray queries against a Scene's triangles, spheres and instances, by Embree 3.13 or 4. The only
// place that includes rtcore.h is embree_scene.cpp. Built once; queries: any thread.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>

#include "core/base/result.h"
#include "core/math/ray.h"
#include "core/math/wide.h"
#include "core/scene/scene.h"

namespace qray {

struct Hit {
  float t = 0;       // metres along the ray
  Vec2 barycentric;  // weights of the triangle's second and third vertex
  Vec3 ng;           // geometric normal by the winding, of a sphere outward; not unit
  MeshId mesh;       // of the scene's meshes; from their count on, of its instances
  uint32_t triangle = 0;
};

// Hits of rays side by side.
struct HitLanes {
  FloatLanes t;
  FloatLanes second, third;  // barycentric
  Vec3Lanes ng;
  std::array<uint32_t, kWidth> mesh{}, triangle{};
  Hit operator[](int lane) const {
    const auto i = static_cast<size_t>(lane);
    return {t[lane], {second[lane], third[lane]}, ng[lane], MeshId(mesh[i]), triangle[i]};
  }
};

// An occlusion query that waits to be answered with others. Laid out as Embree's RTCRay.
struct alignas(16) OcclusionRay {
  OcclusionRay() = default;
  explicit OcclusionRay(const Ray& ray) : o(ray.o), d(ray.d), t_max(ray.t_max) {}
  bool occluded() const { return t_max < 0; }  // once answered

  Vec3 o;
  float t_min = 0;
  Vec3 d;
  float time = 0;
  float t_max = 0;
  uint32_t mask = ~0u, id = 0, flags = 0;
};

// Hits that do not count. `passes` is asked of every hit on the meshes named (with an instance that
// is, on all instances of its mesh, the ray in the mesh's space), in no order, by any thread; it
// must answer the same whenever it is asked.
struct HitFilter {
  std::vector<bool> meshes;  // by Hit::mesh
  std::function<bool(const Ray& ray, const Hit& hit)> passes;
};
// The same of occlusion queries: what of the light passes a hit on the meshes named. Black: the hit
// is in the way.
struct LightFilter {
  std::vector<bool> meshes;
  std::function<Rgb(const Ray& ray, const Hit& hit)> passed;
};
struct HitFilters {
  HitFilter intersect;
  LightFilter occluded;
};

class EmbreeScene {
 public:
  // Called with how much of the tree is built, [0, 1], by several threads at once. False: no more.
  using Progress = std::function<bool(double fraction)>;

  // Copies the scene's triangles. `build_threads` build the tree; fails when memory runs out, or
  // with kCanceled.
  static Result<std::unique_ptr<EmbreeScene>> build(const Scene& scene, int build_threads,
                                                    HitFilters filters = {},
                                                    const Progress& progress = {});
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  size_t size_bytes() const;  // of memory

  bool intersect(const Ray& ray, Hit& hit) const;  // nearest hit in (0, t_max)
  // The same of several rays at once, of these lanes; the lanes that have a hit come back.
  uint32_t intersect(const Vec3Lanes& o, const Vec3Lanes& d, uint32_t lanes, HitLanes& hits) const;
  // Any hit in (0, t_max)? Embree 3 answers a thousand in 2/3 of the time of one by one. Each ray's
  // `id` is its number among `passed`, which what the ray passes is multiplied into.
  void occluded(std::span<OcclusionRay> rays, std::span<Rgb> passed) const;

 private:
  struct Impl;
  explicit EmbreeScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  void* scene_ = nullptr;  // RTCScene, at hand for the queries
};

}  // namespace qray
