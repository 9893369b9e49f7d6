#include "core/render/light_pick.h"

#include <algorithm>
#include <cmath>

#include "core/math/warp.h"

namespace qray {
namespace {

constexpr uint32_t kNoTriangle = ~0u;

Vec3 rotate_y(Vec3 d, float degrees) {
  if (degrees == 0) return d;
  const float a = degrees * (kPi / 180), c = std::cos(a), s = std::sin(a);
  return {d.x * c + d.z * s, d.y, d.z * c - d.x * s};
}

// Luminance of each texel averaged with its neighbours, since lookups interpolate: the density is
// positive wherever the picture is.
std::vector<float> environment_weights(const Image& image) {
  const int w = image.width(), h = image.height();
  std::vector<float> weights;
  weights.reserve(static_cast<size_t>(w) * static_cast<size_t>(h));
  for (int y = 0; y < h; ++y) {
    const float sin_theta = std::sin(kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(h));
    for (int x = 0; x < w; ++x) {
      float sum = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          sum += luminance(image.rgb((x + dx + w) % w, std::clamp(y + dy, 0, h - 1)));
      weights.push_back(sum / 9 * sin_theta);
    }
  }
  return weights;
}

float mean_luminance(const Environment& environment, const std::vector<float>& weights) {
  const float factor = luminance(environment.radiance);
  if (weights.empty()) return factor;
  double sum = 0;
  for (float w : weights) sum += w;
  return factor * static_cast<float>(sum / static_cast<double>(weights.size())) * (kPi / 2);
}

}  // namespace

void LightPick::build(const Scene& scene, const Bounds3& bounds) {
  environment_ = scene.environment;
  std::vector<float> powers;
  first_of_mesh_.assign(scene.meshes.size(), kNoTriangle);
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    const Material& material = scene.materials[mesh.material.value];
    if (!material.emits()) continue;
    first_of_mesh_[m] = static_cast<uint32_t>(triangles_.size());
    for (const auto& tri : mesh.triangles) {
      EmittingTriangle t;
      t.p0 = mesh.positions[tri[0]];
      t.e1 = mesh.positions[tri[1]] - t.p0;
      t.e2 = mesh.positions[tri[2]] - t.p0;
      const Vec3 n = cross(t.e1, t.e2);
      t.area = 0.5f * length(n);
      t.n = normalize(n);
      t.emission = material.emission.value;
      t.two_sided = material.emission_two_sided;
      powers.push_back(kPi * t.area * luminance(t.emission) * (t.two_sided ? 2.0f : 1.0f));
      triangles_.push_back(t);
    }
  }
  double triangle_power = 0;
  for (float p : powers) triangle_power += p;
  if (environment_.present()) {
    std::vector<float> weights;
    if (!environment_.image.empty()) {
      weights = environment_weights(environment_.image);
      environment_density_ =
          PiecewiseConstant2D(weights, environment_.image.width(), environment_.image.height());
    }
    // Flux through the scene's disk from all directions; never more than the lights inside have,
    // of which a closed room sees nothing else.
    float power = 4 * kPi * kPi * sqr(bounds.radius()) * mean_luminance(environment_, weights);
    if (triangle_power > 0) power = std::min(power, static_cast<float>(triangle_power));
    powers.push_back(power);
  }
  if (!powers.empty()) set_picker(powers);
}

void LightPick::set_picker(std::span<const float> weights) {
  picker_ = AliasTable(weights);
  for (size_t i = 0; i < triangles_.size(); ++i)
    triangles_[i].pick_probability = picker_.probability(static_cast<uint32_t>(i));
  if (environment_.present())
    environment_probability_ = picker_.probability(static_cast<uint32_t>(triangles_.size()));
}

LightPick LightPick::uniform() const {
  LightPick other = *this;
  if (!empty()) other.set_picker(std::vector<float>(picker_.size(), 1.0f));
  return other;
}

float LightPick::brightest() const {
  float brightest = 0;
  for (const EmittingTriangle& t : triangles_)
    brightest = std::max(brightest, luminance(t.emission));
  if (!environment_.present()) return brightest;
  float texel = environment_.image.empty() ? 1.0f : 0.0f;
  for (int y = 0; y < environment_.image.height(); ++y)
    for (int x = 0; x < environment_.image.width(); ++x)
      texel = std::max(texel, luminance(environment_.image.rgb(x, y)));
  return std::max(brightest, texel * luminance(environment_.radiance));
}

bool LightPick::picks_uniformly() const {
  for (uint32_t i = 1; i < picker_.size(); ++i)
    if (std::abs(picker_.probability(i) / picker_.probability(0) - 1) > 1e-3f) return false;
  return true;
}

bool LightPick::sample_environment(Vec2 u, LightSample& out) const {
  if (environment_.image.empty()) {
    out.wi = square_to_uniform_sphere(u);
  } else {
    const PiecewiseConstant2D::Sample s = environment_density_.sample(u);
    const float theta = s.uv.y * kPi, phi = (s.uv.x - 0.5f) * 2 * kPi;
    const float sin_theta = std::sin(theta);
    out.wi = rotate_y({sin_theta * std::sin(phi), std::cos(theta), -sin_theta * std::cos(phi)},
                      environment_.rotation_deg);
  }
  out.distance = std::numeric_limits<float>::infinity();
  out.radiance = environment_radiance(out.wi);
  out.pdf_w = pdf_w_environment(out.wi);
  return out.pdf_w > 0;
}

float LightPick::pdf_w_triangle(MeshId mesh, uint32_t triangle, float distance,
                                float abs_cos_light) const {
  const EmittingTriangle& t = triangles_[first_of_mesh_[mesh.value] + triangle];
  return t.pick_probability * sqr(distance) / (abs_cos_light * t.area);
}

Vec2 LightPick::environment_uv(Vec3 wi) const {
  const Vec3 d = rotate_y(wi, -environment_.rotation_deg);
  const float u = 0.5f + std::atan2(d.x, -d.z) * (0.5f * kInvPi);
  const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) * kInvPi;
  return {std::clamp(u, 0.0f, kOneMinusEpsilon), std::clamp(v, 0.0f, kOneMinusEpsilon)};
}

float LightPick::pdf_w_environment(Vec3 wi) const {
  if (environment_.image.empty()) return environment_probability_ * kUniformSpherePdfW;
  const Vec2 uv = environment_uv(wi);
  const float sin_theta = std::sin(uv.y * kPi);
  if (!(sin_theta > 0)) return 0;
  return environment_probability_ * environment_density_.pdf(uv) / (2 * kPi * kPi * sin_theta);
}

Rgb LightPick::environment_radiance(Vec3 wi) const {
  const Image& image = environment_.image;
  if (image.empty()) return environment_.radiance;
  const Vec2 uv = environment_uv(wi);
  const int w = image.width(), h = image.height();
  const float x = uv.x * static_cast<float>(w) - 0.5f, y = uv.y * static_cast<float>(h) - 0.5f;
  const float fx = x - std::floor(x), fy = y - std::floor(y);
  const int x0 = (static_cast<int>(std::floor(x)) + w) % w, x1 = (x0 + 1) % w;
  const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, h - 1),
            y1 = std::min(y0 + 1, h - 1);
  const Rgb top = lerp(fx, image.rgb(x0, y0), image.rgb(x1, y0));
  const Rgb bottom = lerp(fx, image.rgb(x0, y1), image.rgb(x1, y1));
  return environment_.radiance * lerp(fy, top, bottom);
}

}  // namespace qray
