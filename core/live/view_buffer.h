// What a camera sees at each pixel of a frame: what recovery wants to know of it, and where it is,
// so that the next frame finds it again. Any thread.
#pragma once

#include <vector>

#include "core/recover/network.h"
#include "core/render/features.h"

namespace qray {

struct ViewBuffer {
  int width = 0, height = 0;
  CameraRays camera{Camera{}, 1, 1};
  Image features;  // render_features()
  // As far along the pixel's ray as the light came: what is seen in a plane mirror lies behind it.
  std::vector<Vec3> points;
  std::vector<uint32_t> surfaces;  // Seen::surface
  // Mean over the pixel of what lights show of themselves: so bright beside what they light that
  // few samples make their edges flicker.
  std::vector<Rgb> emitted;
  std::vector<uint8_t> crossed;  // 1: an edge of a light may lie in the pixel

  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
  bool empty() const { return points.empty(); }
  bool shows_light(size_t i) const { return !emitted.empty() && !emitted[i].is_black(); }
  Vec3 normal(size_t i) const {
    const float* f = &features.data()[i * kFeatureChannels + 3];
    return {f[0], f[1], f[2]};
  }
  // By what a pixel's samples are divided while they are kept. White where features are not known.
  Rgb albedo(size_t i) const {
    if (features.empty()) return Rgb{1};
    const float* f = &features.data()[i * kFeatureChannels];
    return Rgb{f[0], f[1], f[2]} + Rgb{kAlbedoFloor};
  }
  // Whether two pixels side by side show one surface.
  bool same_surface(size_t a, size_t b) const {
    return surfaces[a] == surfaces[b] &&
           (surfaces[a] == Seen{}.surface || dot(normal(a), normal(b)) > kLeastCosine);
  }
  static constexpr float kLeastCosine = 0.9f;  // between normals a pixel apart
  float kind(size_t i) const { return features.data()[i * kFeatureChannels + 7]; }
};

ViewBuffer see_view(const PreparedScene& scene, const Camera& camera, int width, int height,
                    TaskPool& pool);

// Adds what lights show of themselves to a picture of this camera, perhaps larger than the view:
// enlarged, their edges would be the picture's worst.
void add_emitted(const PreparedScene& scene, const ViewBuffer& view, const Camera& camera,
                 Image& picture, TaskPool& pool);

}  // namespace qray
