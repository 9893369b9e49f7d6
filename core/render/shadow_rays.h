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
  Rgb* pixel = nullptr;
  Rgb* layer = nullptr;  // the pixel's, of the light scattered so often; null: not kept apart
  Rgb* group = nullptr;  // the same, of the light's group
  Rgb scattered;         // the same, before the path's throughput
  uint32_t vertex = 0;   // PathLearner::current()
  bool punctual = false;
  uint32_t pick = 0;          // LightLearner::picked()
  float unguided_weight = 1;  // times: its weight against the BSDF's density, not the mixture's
};

class ShadowRays {
 public:
  // To be filled in there, which is faster than to copy what was just written.
  AwaitedLight& add(const Ray& ray) {
    rays_.emplace_back(ray).id = static_cast<uint32_t>(awaited_.size());
    return awaited_.emplace_back();
  }
  bool enough() const { return awaited_.size() >= kRaysAtOnce; }
  size_t size() const { return awaited_.size(); }
  void trace(const EmbreeScene& scene) {
    if (awaited_.empty()) return;
    passed_.assign(awaited_.size(), Rgb{1.0f});
    scene.occluded(rays_, passed_);
  }
  // Calls body(awaited, passed) for each whose ray was traced and is free, in the order in which
  // they were added. `passed`: what of the light the panes on its way let pass.
  template <class Body>
  void for_each_free(Body body) const {
    for (size_t i = 0; i < awaited_.size(); ++i)
      if (!rays_[i].occluded()) body(awaited_[i], passed_[i]);
  }
  void clear() {
    awaited_.clear();
    rays_.clear();
  }

 private:
  static constexpr size_t kRaysAtOnce = 1024;
  std::vector<AwaitedLight> awaited_;
  std::vector<OcclusionRay> rays_;  // parallel
  std::vector<Rgb> passed_;         // parallel, once traced
};

}  // namespace qray
