#include "core/live/view_buffer.h"

namespace qray {
namespace {

constexpr float kFarDiagonals = 1e4f;  // where the environment is
constexpr int kEdgeRays = 4;           // along each side of a pixel that a light's edge may cross

// Pixels whose neighbours see something else, where one of them emits.
bool crossed_by_light(const ViewBuffer& view, const std::vector<Rgb>& centres, int x, int y) {
  const size_t i = view.index(x, y);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = x + dx, ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= view.width || ny >= view.height) continue;
      const size_t n = view.index(nx, ny);
      if (view.surfaces[n] != view.surfaces[i] && !(centres[n].is_black() && centres[i].is_black()))
        return true;
    }
  return false;
}

void smooth_edges_of_lights(const PreparedScene& scene, float diagonal, ViewBuffer& view,
                            TaskPool& pool) {
  const std::vector<Rgb> centres = view.emitted;
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      if (!crossed_by_light(view, centres, x, y)) continue;
      Rgb sum;
      for (int k = 0; k < kEdgeRays * kEdgeRays; ++k) {
        // Rows of points that no line meets all at once.
        const float across = (static_cast<float>(k % kEdgeRays) + 0.5f) / kEdgeRays;
        const float down = (static_cast<float>(k) + 0.5f) / (kEdgeRays * kEdgeRays);
        const Ray ray = view.camera.ray(
            {static_cast<float>(x) + across, static_cast<float>(y) + down}, {0.5f, 0.5f});
        sum += see(scene, ray, diagonal, view.camera.pixel_angle()).emitted;
      }
      view.emitted[view.index(x, y)] = sum / static_cast<float>(kEdgeRays * kEdgeRays);
    }
  });
}

}  // namespace

ViewBuffer see_view(const PreparedScene& scene, const Camera& camera, int width, int height,
                    TaskPool& pool) {
  ViewBuffer view{
      width, height, CameraRays(camera, width, height), Image(width, height, kFeatureChannels), {},
      {},    {}};
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  view.points.resize(pixels);
  view.surfaces.resize(pixels);
  view.emitted.resize(pixels);
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
      view.emitted[i] = seen.emitted;
    }
  });
  smooth_edges_of_lights(scene, diagonal, view, pool);
  return view;
}

}  // namespace qray
