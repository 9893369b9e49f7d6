#include "core/live/view_buffer.h"

namespace qray {
namespace {

constexpr float kFarDiagonals = 1e4f;  // where the environment is

}  // namespace

ViewBuffer see_view(const PreparedScene& scene, const Camera& camera, int width, int height,
                    TaskPool& pool) {
  ViewBuffer view{width, height, CameraRays(camera, width, height),
                  Image(width, height, kFeatureChannels), {}, {}};
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  view.points.resize(pixels);
  view.surfaces.resize(pixels);
  const float diagonal = std::max(length(scene.bounds.hi - scene.bounds.lo), 1e-30f);
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const Ray ray = view.camera.ray({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f},
                                      {0.5f, 0.5f});
      const Seen seen = see(scene, ray, diagonal, view.camera.pixel_angle());
      const size_t i = view.index(x, y);
      std::copy(seen.features.begin(), seen.features.end(),
                view.features.data().begin() + static_cast<std::ptrdiff_t>(i * kFeatureChannels));
      view.points[i] = ray.o + ray.d * std::min(seen.distance, diagonal * kFarDiagonals);
      view.surfaces[i] = seen.surface;
    }
  });
  return view;
}

}  // namespace qray
