// Light that waits for its shadow ray: many are traced at once, which is faster than one by one.
// Whatever else a path brings waits in turn.
// One per PathTracer.
#pragma once

#include <vector>

#include "core/accel/embree_scene.h"
#include "core/math/vec.h"

namespace qray {

// Light that a pixel is paid if nothing is in the way.
struct AwaitedLight {
  static constexpr uint32_t kNoRay = ~0u;
  uint32_t ray = kNoRay;
  Rgb light;
  Rgb* pixel = nullptr;   // null: its layers alone
  Rgb* layer = nullptr;   // the pixel's, of the light scattered so often; null: not kept apart
  Rgb* group = nullptr;   // the same, of the light's group
  Rgb scattered;          // the same, before the path's throughput
  int lane = 0;           // of the path
  uint32_t vertex = ~0u;  // PathLearner::current()
  bool punctual = false;
  uint32_t pick = ~0u;        // LightLearner::picked()
  float unguided_weight = 1;  // times: its weight against the BSDF's density, not the mixture's
};

class ShadowRays {
 public:
  // To be filled in there, which is faster than to copy what was just written.
  AwaitedLight& add(const Ray& ray) {
    const auto number = static_cast<uint32_t>(rays_.size());
    rays_.emplace_back(ray).id = number;
    AwaitedLight& awaited = awaited_.emplace_back();
    awaited.ray = number;
    return awaited;
  }
  // Light that arrives in any case. It waits in turn, so that a path's light is added up in the
  // order in which it was met, whatever paths are traced beside it.
  AwaitedLight& add_without_ray() { return awaited_.emplace_back(); }
  bool enough() const { return rays_.size() >= kRaysAtOnce; }
  void trace(const EmbreeScene& scene) {
    if (rays_.empty()) return;
    passed_.assign(rays_.size(), Rgb{1.0f});
    scene.occluded(rays_, passed_);
  }
  // Calls body(awaited, passed) for each that arrives, in the order in which they were added, once
  // the rays are traced. `passed`: what of the light the panes on its way let pass.
  template <class Body>
  void for_each_free(Body body) const {
    for (const AwaitedLight& awaited : awaited_) {
      if (awaited.ray == AwaitedLight::kNoRay) {
        body(awaited, Rgb{1.0f});
      } else if (!rays_[awaited.ray].occluded()) {
        body(awaited, passed_[awaited.ray]);
      }
    }
  }
  void clear() {
    awaited_.clear();
    rays_.clear();
  }

 private:
  static constexpr size_t kRaysAtOnce = 1024;
  std::vector<AwaitedLight> awaited_;
  std::vector<OcclusionRay> rays_;
  std::vector<Rgb> passed_;  // by ray, once traced
};

}  // namespace qray
