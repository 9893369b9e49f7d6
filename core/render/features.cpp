#include "core/render/features.h"

#include <algorithm>

#include "core/math/frame.h"

namespace qray {
namespace {

constexpr int kMostMirrors = 8;
constexpr float kFar = 2, kNoSurface = 2;
// Far enough apart that a kernel tells them: kinds differ by their squares.
constexpr float kGlossyKind = 0.25f, kMixedKind = 0.5f, kEmitting = 1, kBehindMirror = 0.75f;

float kind_of(BsdfKind bsdf, bool emits, bool mirrored) {
  float kind = 0;
  if (bsdf == BsdfKind::kGlossy) kind = kGlossyKind;
  if (bsdf == BsdfKind::kMixed) kind = kMixedKind;
  if (emits) kind = kEmitting;
  return mirrored ? kind + kBehindMirror : kind;
}

// Toward where the ray comes from.
Rgb emitted_at(const PreparedScene& scene, const MeshShading& mesh, const SurfacePoint& at,
               Vec3 ray_d) {
  if (!mesh.emits || (dot(at.ng, ray_d) > 0 && !mesh.material->emission_two_sided)) return {};
  return mesh.emission_textured() ? scene.textures->color(mesh.material->emission, at.uv)
                                  : mesh.material->emission.value;
}

// Of four rays within a pixel, rows and columns of their own.
struct EdgeRay {
  float x, y;
};
constexpr EdgeRay kEdgeRays[] = {
    {0.125f, 0.625f}, {0.375f, 0.125f}, {0.625f, 0.875f}, {0.875f, 0.375f}};
constexpr int kBandRows = 32;  // seen by one thread, so that little memory is read twice
constexpr float kLeastCosine = 0.9f, kMostDepthStep = 0.1f;  // of one surface from pixel to pixel

bool differ(const Seen& a, const Seen& b) {
  const auto& f = a.features;
  const auto& g = b.features;
  return a.surface != b.surface ||
         f[3] * g[3] + f[4] * g[4] + f[5] * g[5] < kLeastCosine * (f[7] < kNoSurface) ||
         std::abs(f[6] - g[6]) > kMostDepthStep * std::min(f[6], g[6]);
}

}  // namespace

Seen see(const PreparedScene& scene, Ray ray, float diagonal, PixelCone pixel) {
  Rgb tint{1}, emitted;
  float length = 0;
  for (int mirrors = 0; mirrors <= kMostMirrors; ++mirrors) {
    Hit hit;
    if (!scene.accel->intersect(ray, hit)) {
      if (mirrors > 0) break;
      tint = Rgb{};
      if (scene.lights.has_environment()) emitted = scene.lights.environment_radiance(ray.d);
      break;
    }
    const SurfacePoint at = scene.surface_at(ray, hit, pixel.at(length + hit.t));
    const MeshShading& mesh = scene.meshes[hit.mesh.value];
    const Rgb shines = emitted_at(scene, mesh, at, ray.d);
    if (mirrors == 0) emitted = shines;
    const MaterialShading& material = scene.resolve(mesh, at.uv, 0.5f);
    const Frame frame = scene.frame_at(material, hit, at.ns, at.uv);
    const Vec3 wo = frame.to_local(-ray.d);
    ShadingPoint room;
    const BsdfPoint bsdf_at = material.bsdf->at(scene.shading_point(material, at, room), wo);
    length += hit.t;
    if (material.kind == BsdfKind::kDelta && !mesh.emits && mirrors < kMostMirrors) {
      // The likelier of what is reflected and what shines through.
      const std::optional<BsdfSample> s = material.bsdf->sample(bsdf_at, 0.5f, {0.5f, 0.5f});
      if (!s) break;
      tint = tint * s->weight;
      const Vec3 wi = frame.to_world(s->wi);
      const float side = dot(at.ng, wi) < 0 ? -1.0f : 1.0f;
      ray = Ray{at.p + at.ng * (side * scene.ray_epsilon), wi};
      continue;
    }
    Rgb albedo = material.bsdf->albedo(bsdf_at);
    // What is seen to shine directly is taken off before recovery; in a mirror it is not.
    for (int c = 0; c < 3; ++c)
      albedo[c] = tint[c] * std::max(albedo[c], mirrors == 0 ? 0.0f : std::min(shines[c], 1.0f));
    const Vec3 n = wo.z < 0 ? -at.ns : at.ns;
    return {{albedo.r, albedo.g, albedo.b, n.x, n.y, n.z, length / diagonal,
             kind_of(material.kind, mesh.emits, mirrors > 0)},
            length,
            hit.mesh.value | static_cast<uint32_t>(mirrors) << kMirrorShift,
            emitted};
  }
  Seen nothing;
  nothing.features = {tint.r, tint.g, tint.b, 0, 0, 0, kFar, kNoSurface};
  nothing.emitted = emitted;
  return nothing;
}

Result<FeaturePictures> render_features(const PreparedScene& scene, const RenderSettings& settings,
                                        TaskPool& pool, std::stop_token stop) {
  const CameraRays camera(settings.camera.value_or(scene.scene.camera), settings.width,
                          settings.height);
  const float diagonal = std::max(length(scene.bounds.hi - scene.bounds.lo), 1e-30f);
  const int width = settings.width, height = settings.height;
  const auto look = [&](float x, float y, Vec2 lens) {
    return see(scene, camera.ray({x, y}, lens), diagonal, camera.cone());
  };
  const auto mean_of_edge_rays = [&](int x, int y) {
    Seen mean;
    for (const EdgeRay& r : kEdgeRays) {
      const Seen part = look(static_cast<float>(x) + r.x, static_cast<float>(y) + r.y, {r.y, r.x});
      constexpr float kShare = 1.0f / std::size(kEdgeRays);
      for (size_t k = 0; k < kFeatureChannels; ++k) mean.features[k] += kShare * part.features[k];
      mean.emitted += part.emitted * kShare;
    }
    return mean;
  };
  FeaturePictures pictures{Image::unset(width, height, kFeatureChannels),
                           Image::unset(width, height, 3)};
  const auto bands = static_cast<size_t>((height + kBandRows - 1) / kBandRows);
  pool.run(bands, [&](size_t band, int) {
    if (stop.stop_requested()) return;
    const int top = static_cast<int>(band) * kBandRows, end = std::min(height, top + kBandRows);
    // With the rows beside the band, which tell whether its own pixels lie at an edge.
    const int first = std::max(0, top - 1), last = std::min(height, end + 1);
    std::vector<Seen> centres;
    centres.reserve(static_cast<size_t>(last - first) * static_cast<size_t>(width));
    for (int y = first; y < last; ++y)
      for (int x = 0; x < width; ++x)
        centres.push_back(
            look(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, {0.5f, 0.5f}));
    const auto centre = [&](int x, int y) -> const Seen& {
      return centres[static_cast<size_t>(y - first) * static_cast<size_t>(width) +
                     static_cast<size_t>(x)];
    };
    for (int y = top; y < end; ++y)
      for (int x = 0; x < width; ++x) {
        const Seen& seen = centre(x, y);
        const bool edge = (x > 0 && differ(seen, centre(x - 1, y))) ||
                          (y > 0 && differ(seen, centre(x, y - 1))) ||
                          (x + 1 < width && differ(seen, centre(x + 1, y))) ||
                          (y + 1 < height && differ(seen, centre(x, y + 1)));
        const Seen shown = edge || camera.has_lens() ? mean_of_edge_rays(x, y) : seen;
        for (int k = 0; k < kFeatureChannels; ++k)
          pictures.features.at(x, y, k) = shown.features[static_cast<size_t>(k)];
        pictures.emitted.set_rgb(x, y, shown.emitted);
      }
  });
  if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
  return pictures;
}

}  // namespace qray
