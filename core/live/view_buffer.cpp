#include "core/live/view_buffer.h"

namespace qray {
namespace {

constexpr float kFarDiagonals = 1e4f;  // where the environment is
// Along each side of a pixel that a light's edge may cross; where pixels are smaller than the
// view's.
constexpr int kEdgeRays = 4, kSmallEdgeRays = 2;

// Whether the pixel's neighbours see something else, and one of them a light.
bool crossed_by_light(const ViewBuffer& view, int x, int y) {
  const size_t i = view.index(x, y);
  const bool shines = view.shows_light(i);
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, view.height - 1); ++ny)
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, view.width - 1); ++nx) {
      const size_t n = view.index(nx, ny);
      if (view.surfaces[n] != view.surfaces[i] && (shines || view.shows_light(n))) return true;
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

// Where lights show, few rows do.
std::vector<bool> rows_with_light(const ViewBuffer& view) {
  std::vector<bool> rows(static_cast<size_t>(view.height));
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width && !rows[static_cast<size_t>(y)]; ++x)
      rows[static_cast<size_t>(y)] = view.shows_light(view.index(x, y));
  return rows;
}

void smooth_edges_of_lights(const PreparedScene& scene, float diagonal, ViewBuffer& view,
                            TaskPool& pool) {
  const std::vector<bool> light = rows_with_light(view);
  const auto rows = static_cast<size_t>(view.height);
  view.crossed.assign(view.emitted.size(), 0);
  pool.run(rows, [&](size_t row, int) {
    if (!light[row] && !(row > 0 && light[row - 1]) && !(row + 1 < rows && light[row + 1])) return;
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x)
      view.crossed[view.index(x, y)] = crossed_by_light(view, x, y);
  });
  pool.run(rows, [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x)
      if (const size_t i = view.index(x, y); view.crossed[i])
        view.emitted[i] = emitted_in_pixel(scene, diagonal, view.camera, x, y, kEdgeRays);
  });
}

}  // namespace

ViewBuffer see_view(const PreparedScene& scene, const Camera& camera, int width, int height,
                    TaskPool& pool) {
  ViewBuffer view{width,
                  height,
                  CameraRays(camera, width, height),
                  Image(width, height, kFeatureChannels),
                  {},
                  {},
                  {},
                  {}};
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
      const size_t i = view.index(vx, vy);
      const Rgb emitted = !same && view.crossed[i]
                              ? emitted_in_pixel(scene, diagonal, rays, x, y, kSmallEdgeRays)
                              : view.emitted[i];
      picture.set_rgb(x, y, picture.rgb(x, y) + emitted);
    }
  });
}

}  // namespace qray
