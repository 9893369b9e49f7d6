// Light that waits for its shadow ray: many are traced at once, which is faster than one by one.
// One per PathTracer.
#pragma once

#include <vector>

#include "core/accel/embree_scene.h"
#include "core/math/vec.h"

namespace qray {

// Light that a pixel is paid if nothing is in the way.
struct AwaitedLight {
  Rgb light;
  Rgb* pixel;
  Rgb* layer;       // the pixel's, of the light scattered so often; null: not kept apart
  Rgb* group;       // the same, of the light's group
  Rgb scattered;    // the same, before the path's throughput
  uint32_t vertex;  // PathLearner::current()
  bool punctual;
  uint32_t pick;          // LightLearner::picked()
  float unguided_weight;  // times: its weight against the BSDF's density, not the mixture's
};

class ShadowRays {
 public:
  void add(const Ray& ray, const AwaitedLight& awaited) {
    awaited_.push_back(awaited);
    rays_.emplace_back(ray);
  }
  bool enough() const { return awaited_.size() >= kRaysAtOnce; }
  size_t size() const { return awaited_.size(); }
  void trace(const EmbreeScene& scene) {
    if (!awaited_.empty()) scene.occluded(rays_);
  }
  // Calls body(awaited) for each whose ray was traced and met something.
  template <class Body>
  void for_each_blocked(Body body) const {
    for (size_t i = 0; i < awaited_.size(); ++i)
      if (rays_[i].occluded()) body(awaited_[i]);
  }
  // Calls body(awaited) for each whose ray was traced and is free, in the order in which they were
  // added.
  template <class Body>
  void for_each_free(Body body) const {
    for (size_t i = 0; i < awaited_.size(); ++i)
      if (!rays_[i].occluded()) body(awaited_[i]);
  }
  void clear() {
    awaited_.clear();
    rays_.clear();
  }

 private:
  static constexpr size_t kRaysAtOnce = 1024;
  std::vector<AwaitedLight> awaited_;
  std::vector<OcclusionRay> rays_;  // parallel
};

}  // namespace qray
