#include "core/render/debug_view.h"

#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/sampler.h"

namespace qray {
namespace {

Rgb value_at(const PreparedScene& scene, DebugView view, const Guide* guide, const Ray& ray) {
  Hit hit;
  if (!scene.accel->intersect(ray, hit)) return {};
  const MeshShading& mesh = scene.meshes[hit.mesh.value];
  const SurfacePoint surface = scene.surface_at(ray, hit);
  switch (view) {
    case DebugView::kAlbedo:
      return mesh.bsdf->albedo(scene.shading_point(mesh, surface.uv),
                               Frame(surface.ns).to_local(-ray.d));
    case DebugView::kNormal: {
      const Vec3 n = surface.ns * 0.5f;
      return {n.x + 0.5f, n.y + 0.5f, n.z + 0.5f};
    }
    case DebugView::kState: {
      const Vec3 facing = dot(surface.ng, ray.d) > 0 ? -surface.ng : surface.ng;
      return state_color(guide->find(surface.p, facing).key);
    }
  }
  return {};
}

}  // namespace

Rgb state_color(uint64_t key) {
  const uint64_t h = mix64(key + 1);
  const float hue = static_cast<float>(h & 0xffff) / 65536.0f * 6;
  const float value = 0.35f + 0.65f * static_cast<float>(h >> 16 & 0xff) / 255.0f;
  const auto channel = [&](float shift) {  // a hexagonal hue circle
    const float d = std::abs(std::fmod(hue + shift, 6.0f) - 3);
    return value * std::clamp(d - 1, 0.08f, 1.0f);
  };
  return {channel(0), channel(4), channel(2)};
}

Result<Image> render_debug_view(const PreparedScene& scene, const RenderSettings& settings,
                                DebugView view, int samples_per_pixel, TaskPool& pool,
                                std::stop_token stop) {
  std::unique_ptr<Guide> guide;
  if (view == DebugView::kState) {
    const std::string method = settings.method == "none" ? "huang" : settings.method;
    Result<std::unique_ptr<Guide>> made = make_guide(method, scene.guide_setup(settings));
    if (!made) return made.error();
    guide = std::move(made).value();
  }
  const CameraRays camera(settings.camera.value_or(scene.scene.camera), settings.width,
                          settings.height);
  Image image(settings.width, settings.height, 3);
  pool.run(static_cast<size_t>(settings.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    Sampler sampler(settings.seed);
    for (int x = 0; x < settings.width && !stop.stop_requested(); ++x) {
      Rgb sum;
      for (int s = 0; s < samples_per_pixel; ++s) {
        sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), static_cast<uint32_t>(s));
        const Vec2 jitter = sampler.next_2d();
        const Vec2 pixel{static_cast<float>(x) + jitter.x, static_cast<float>(y) + jitter.y};
        sum += value_at(scene, view, guide.get(), camera.ray(pixel, sampler.next_2d()));
      }
      image.set_rgb(x, y, sum / static_cast<float>(samples_per_pixel));
    }
  });
  if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
  return image;
}

}  // namespace qray
