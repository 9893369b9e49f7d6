// Ray queries against a Scene's triangles, by Embree 3.13 or 4. The only place that includes
// rtcore.h is embree_scene.cpp. Built once; queries: any thread.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/math/ray.h"
#include "core/scene/scene.h"

namespace qray {

struct Hit {
  float t = 0;       // metres along the ray
  Vec2 barycentric;  // weights of the triangle's second and third vertex
  Vec3 ng;           // geometric normal by the winding; not unit
  MeshId mesh;
  uint32_t triangle = 0;
};

class EmbreeScene {
 public:
  // Copies the scene's triangles. `build_threads` build the tree; fails when memory runs out.
  static Result<std::unique_ptr<EmbreeScene>> build(const Scene& scene, int build_threads);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  bool intersect(const Ray& ray, Hit& hit) const;  // nearest hit in (0, t_max)
  bool occluded(const Ray& ray) const;             // any hit in (0, t_max)

 private:
  struct Impl;
  explicit EmbreeScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  void* scene_ = nullptr;  // RTCScene, at hand for the queries
};

}  // namespace qray
