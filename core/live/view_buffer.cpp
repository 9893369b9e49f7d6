#include "core/live/view_buffer.h"

namespace qray {
namespace {

constexpr float kFarDiagonals = 1e4f;  // where the environment is
// Along each side of a pixel that a light's edge may cross; where pixels are smaller than the
// view's.
constexpr int kEdgeRays = 4, kSmallEdgeRays = 2;

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

// Mean over a pixel of what lights show of themselves, from `side` x `side` rays.
Rgb emitted_in_pixel(const PreparedScene& scene, float diagonal, const CameraRays& camera, int x,
                     int y, int side) {
  Rgb sum;
  for (int k = 0; k < side * side; ++k) {
    // Rows of points that no line meets all at once.
    const float across = (static_cast<float>(k % side) + 0.5f) / static_cast<float>(side);
    const float down = (static_cast<float>(k) + 0.5f) / static_cast<float>(side * side);
    const Ray ray =
        camera.ray({static_cast<float>(x) + across, static_cast<float>(y) + down}, {0.5f, 0.5f});
    sum += see(scene, ray, diagonal, camera.cone()).emitted;
  }
  return sum / static_cast<float>(side * side);
}

float diagonal_of(const PreparedScene& scene) {
  return std::max(length(scene.bounds.hi - scene.bounds.lo), 1e-30f);
}

void smooth_edges_of_lights(const PreparedScene& scene, float diagonal, ViewBuffer& view,
                            TaskPool& pool) {
  const std::vector<Rgb> centres = view.emitted;
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      if (!crossed_by_light(view, centres, x, y)) continue;
      view.emitted[view.index(x, y)] =
          emitted_in_pixel(scene, diagonal, view.camera, x, y, kEdgeRays);
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
  const float diagonal = diagonal_of(scene);
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const Ray ray = view.camera.ray({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f},
                                      {0.5f, 0.5f});
      const Seen seen = see(scene, ray, diagonal, view.camera.cone());
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

void add_emitted(const PreparedScene& scene, const ViewBuffer& view, const Camera& camera,
                 Image& picture, TaskPool& pool) {
  const CameraRays rays(camera, picture.width(), picture.height());
  const float diagonal = diagonal_of(scene);
  const bool same = picture.width() == view.width;
  pool.run(static_cast<size_t>(picture.height()), [&](size_t row, int) {
    const int y = static_cast<int>(row), vy = y * view.height / picture.height();
    for (int x = 0; x < picture.width(); ++x) {
      const int vx = x * view.width / picture.width();
      const Rgb emitted = !same && crossed_by_light(view, view.emitted, vx, vy)
                              ? emitted_in_pixel(scene, diagonal, rays, x, y, kSmallEdgeRays)
                              : view.emitted[view.index(vx, vy)];
      picture.set_rgb(x, y, picture.rgb(x, y) + emitted);
    }
  });
}

}  // namespace qray
