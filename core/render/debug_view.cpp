#include "core/render/debug_view.h"

#include "core/image/false_color.h"
#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/sampler.h"

namespace qray {
namespace {

struct ViewName {
  DebugView view;
  std::string_view name, scale;
};
constexpr ViewName kViewNames[] = {
    {DebugView::kAlbedo, "albedo", "linear"},
    {DebugView::kNormal, "normal", "(n + 1) / 2"},
    {DebugView::kState, "state", "a colour a state, black: none"},
    {DebugView::kBeta, "beta", "0 (dark) to 1 (bright)"},
    {DebugView::kGain, "gain", "1 (dark) to 64 (bright), logarithmic"},
};

Rgb guide_color(DebugView view, const GuideInspector& guide, bool learned,
                const SeenSurface& seen) {
  const GuidePoint at = guide.find(seen.point.p, seen.facing);
  if (view == DebugView::kState) return learned && !at.state.valid() ? Rgb{} : state_color(at.key);
  if (!seen.guided) return {};
  if (view == DebugView::kGain) return viridis(log_scale(guide.gain(at), 1, kGainHigh));
  return viridis(guide.mixture(at, *seen.guided).guide);
}

Rgb value_at(const PreparedScene& scene, DebugView view, const GuideInspector* guide, bool learned,
             const Ray& ray) {
  const std::optional<SeenSurface> seen = surface_seen(scene, ray);
  if (!seen) return {};
  if (shows_guide(view)) return guide_color(view, *guide, learned, *seen);
  if (view == DebugView::kAlbedo) {
    const MaterialShading& material = scene.resolve(*seen->mesh, seen->point.uv, 0.5f);
    const Frame frame = scene.frame_at(material, seen->hit, seen->point.ns, seen->point.uv);
    ShadingPoint room;
    return material.bsdf->albedo(material.bsdf->at(scene.shading_point(material, seen->point, room),
                                                   frame.to_local(-ray.d)));
  }
  const Vec3 n = seen->point.ns * 0.5f;
  return {n.x + 0.5f, n.y + 0.5f, n.z + 0.5f};
}

}  // namespace

std::optional<DebugView> parse_debug_view(std::string_view name) {
  for (const ViewName& v : kViewNames)
    if (v.name == name) return v.view;
  return std::nullopt;
}

std::string_view scale_of(DebugView view) { return kViewNames[static_cast<size_t>(view)].scale; }

std::optional<SeenSurface> surface_seen(const PreparedScene& scene, const Ray& ray) {
  Hit hit;
  if (!scene.accel->intersect(ray, hit)) return std::nullopt;
  const SurfacePoint point = scene.surface_at(ray, hit);
  const MeshShading& mesh = scene.meshes[hit.mesh.value];
  SeenSurface seen{point, hit, &mesh, dot(point.ng, ray.d) > 0 ? -point.ng : point.ng, {}};
  const MaterialShading& material = scene.resolve(mesh, point.uv, 0.5f);
  if (material.kind != BsdfKind::kDelta) {
    ShadingPoint room;
    const BsdfPoint bsdf_at =
        material.bsdf->at(scene.shading_point(material, point, room),
                          scene.frame_at(material, hit, point.ns, point.uv).to_local(-ray.d));
    seen.guided = {material.bsdf->parts(bsdf_at).base_chance, material.kind == BsdfKind::kMixed};
  }
  return seen;
}

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
                                DebugView view, const Guide* guide, int samples_per_pixel,
                                TaskPool& pool, std::stop_token stop) {
  QRAY_CHECK(guide || !shows_guide(view));
  const bool learned = guide && guide->stats().samples_seen > 0;
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
        sum += value_at(scene, view, guide, learned, camera.ray(pixel, sampler.next_2d()));
      }
      image.set_rgb(x, y, sum / static_cast<float>(samples_per_pixel));
    }
  });
  if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
  return image;
}

}  // namespace qray
