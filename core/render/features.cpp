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
constexpr float kLeastCosine = 0.9f, kMostDepthStep = 0.1f;  // of one surface from pixel to pixel

// Whether two pixels beside each other show something else.
bool differ(const float* f, uint32_t f_surface, const float* g, uint32_t g_surface) {
  return f_surface != g_surface ||
         f[3] * g[3] + f[4] * g[4] + f[5] * g[5] < kLeastCosine * (f[7] < kNoSurface) ||
         std::abs(f[6] - g[6]) > kMostDepthStep * std::min(f[6], g[6]);
}

// Pixels that differ from one beside them, 1 each, of row y.
std::vector<uint8_t> edges_of(const Image& features, const std::vector<uint32_t>& surfaces, int y) {
  const int width = features.width();
  const auto pixel = [width](int x, int y_) {
    return static_cast<size_t>(y_) * static_cast<size_t>(width) + static_cast<size_t>(x);
  };
  const auto tell_apart = [&](size_t a, size_t b) {
    return differ(&features.data()[a * kFeatureChannels], surfaces[a],
                  &features.data()[b * kFeatureChannels], surfaces[b]);
  };
  std::vector<uint8_t> edges(static_cast<size_t>(width));
  for (int x = 0; x < width; ++x) {
    const auto i = static_cast<size_t>(x);
    if (x + 1 < width && tell_apart(pixel(x, y), pixel(x + 1, y))) edges[i] = edges[i + 1] = 1;
    for (const int beside : {y - 1, y + 1})
      if (beside >= 0 && beside < features.height() && tell_apart(pixel(x, y), pixel(x, beside)))
        edges[i] = 1;
  }
  return edges;
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
    const BsdfPoint bsdf_at = material.bsdf->at(scene.shading_point(material, at), wo);
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
  FeaturePictures pictures{Image::unset(width, height, kFeatureChannels),
                           Image::unset(width, height, 3)};
  std::vector<uint32_t> surfaces(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto show = [&](int x, int y, const Seen& seen) {
    std::ranges::copy(seen.features, &pictures.features.at(x, y, 0));
    pictures.emitted.set_rgb(x, y, seen.emitted);
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    if (stop.stop_requested()) return;
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const Seen seen =
          look(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, {0.5f, 0.5f});
      show(x, y, seen);
      surfaces[row * static_cast<size_t>(width) + static_cast<size_t>(x)] = seen.surface;
    }
  });
  std::vector<std::vector<uint8_t>> edges(static_cast<size_t>(height));
  pool.run(edges.size(), [&](size_t row, int) {
    edges[row] = edges_of(pictures.features, surfaces, static_cast<int>(row));
  });
  pool.run(edges.size(), [&](size_t row, int) {
    if (stop.stop_requested()) return;
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      if (!edges[row][static_cast<size_t>(x)] && !camera.has_lens()) continue;
      Seen mean;
      for (const EdgeRay& r : kEdgeRays) {
        const Seen part =
            look(static_cast<float>(x) + r.x, static_cast<float>(y) + r.y, {r.y, r.x});
        constexpr float kShare = 1.0f / std::size(kEdgeRays);
        for (size_t k = 0; k < kFeatureChannels; ++k) mean.features[k] += kShare * part.features[k];
        mean.emitted += part.emitted * kShare;
      }
      show(x, y, mean);
    }
  });
  if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
  return pictures;
}

}  // namespace qray
