// The one place where a pixel's sample becomes a camera's ray and a path: a job's sample of a
// number and a live view's are the same. One thread's.
#pragma once

#include "core/render/path.h"

namespace qray {

// The camera's ray of the sample that the sampler was started for; the path's numbers follow.
inline Ray pixel_ray(const CameraRays& camera, int x, int y, Sampler& sampler) {
  const Vec2 in_pixel = sampler.next_2d();
  const Vec2 on_lens = camera.has_lens() ? sampler.next_2d() : Vec2{};
  return camera.ray({static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y},
                    on_lens);
}

class PixelSampler {
 public:
  // The camera and the tracer outlive this.
  PixelSampler(const CameraRays& camera, uint64_t seed, PathTracer& tracer)
      : camera_(camera), sampler_(seed), tracer_(tracer) {}

  // Adds the pixel's sample of that number to `to`, some of it only at the tracer's flush().
  // `learn` and `deviation` as PathTracer::sample() takes them.
  void sample(int x, int y, uint32_t number, GuideDelta* learn, float deviation, PixelTarget to) {
    sampler_.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), number);
    const Ray ray = pixel_ray(camera_, x, y, sampler_);
    tracer_.sample(ray, sampler_, learn, deviation, to);
  }

 private:
  const CameraRays& camera_;
  Sampler sampler_;
  PathTracer& tracer_;
};

}  // namespace qray
