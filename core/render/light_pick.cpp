#include "core/render/light_pick.h"

#include <algorithm>
#include <cmath>

#include "core/math/warp.h"
#include "core/scene/surface.h"

namespace qray {
namespace {

constexpr uint32_t kNoTriangle = ~0u;

// What a triangle's images leave of its emission, about; never so little that it is not picked.
float brightness_share(const Mesh& mesh, const Material& material, uint32_t triangle,
                       const MaterialTextures& textures) {
  constexpr int kSteps = 4;  // squared: lookups
  constexpr float kLeast = 0.05f;
  const float whole = luminance(material.emission.value);
  float sum = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const Vec2 b = square_to_triangle({(static_cast<float>(i / kSteps) + 0.5f) / kSteps,
                                       (static_cast<float>(i % kSteps) + 0.5f) / kSteps});
    SurfacePoint surface;
    interpolate_vertices(mesh, triangle, b, surface);
    sum += luminance(textures.color(material.emission, surface.uv)) *
           textures.opacity(material, surface.uv);
  }
  return std::max(kLeast, sum / (kSteps * kSteps) / whole);
}

}  // namespace

void LightPick::build(const Scene& scene, const Bounds3& bounds, const MaterialTextures& textures) {
  std::vector<float> powers;
  const std::vector<Placement> placements = scene.placements();
  first_of_mesh_.assign(placements.size(), kNoTriangle);
  for (size_t i = 0; i < placements.size(); ++i) {
    const Placement& placed = placements[i];
    const Material& material = scene.materials[placed.material.value];
    if (!placed.mesh || !material.emits()) continue;
    first_of_mesh_[i] = static_cast<uint32_t>(triangles_.size());
    const bool mirrored = placed.to_world && placed.to_world->determinant() < 0;
    for (const auto& tri : placed.mesh->triangles) {
      EmittingTriangle t;
      t.p0 = placed.at(placed.mesh->positions[tri[0]]);
      t.e1 = placed.at(placed.mesh->positions[tri[1]]) - t.p0;
      t.e2 = placed.at(placed.mesh->positions[tri[2]]) - t.p0;
      const Vec3 n = mirrored ? cross(t.e2, t.e1) : cross(t.e1, t.e2);
      t.area = 0.5f * length(n);
      t.n = normalize(n);
      t.emission = material.emission.value;
      t.two_sided = material.emission_two_sided;
      t.mesh = MeshId(static_cast<uint32_t>(i));
      t.index = static_cast<uint32_t>(&tri - placed.mesh->triangles.data());
      t.varies = material.emission.texture.valid() || material.opacity.texture.valid() ||
                 material.opacity.value < 1;
      float radiance = luminance(t.emission);
      if (t.varies) radiance *= brightness_share(*placed.mesh, material, t.index, textures);
      powers.push_back(kPi * t.area * radiance * (t.two_sided ? 2.0f : 1.0f));
      triangles_.push_back(t);
    }
  }
  double power_inside = 0;
  for (const PunctualLight& light : scene.lights)
    if (light.emits()) punctual_.push_back(light);
  for (const PunctualLight& light : punctual_)
    powers.push_back(light.kind == LightKind::kDirectional ? 0 : luminance(light.power()));
  for (const float p : powers) power_inside += p;
  // Flux through the scene's disk; never more than the lights inside have, of which a closed room
  // sees nothing else.
  const float disk = kPi * sqr(bounds.radius());
  const auto from_outside = [&](float irradiance) {
    const float power = disk * irradiance;
    return power_inside > 0 ? std::min(power, static_cast<float>(power_inside)) : power;
  };
  for (size_t i = 0; i < punctual_.size(); ++i) {
    if (punctual_[i].kind == LightKind::kDirectional)
      powers[triangles_.size() + i] = from_outside(luminance(punctual_[i].intensity));
  }
  if (scene.environment.present()) {
    environment_ = std::make_shared<EnvironmentLight>(scene.environment);
    powers.push_back(from_outside(4 * kPi * environment_->mean_luminance()));
  }
  if (!powers.empty()) set_picker(powers);
  set_brightest(bounds.radius());
}

void LightPick::set_picker(std::span<const float> weights) {
  picker_ = AliasTable(weights);
  for (size_t i = 0; i < triangles_.size(); ++i)
    triangles_[i].pick_probability = picker_.probability(static_cast<uint32_t>(i));
  if (environment_) environment_probability_ = picker_.probability(picker_.size() - 1);
}

LightPick LightPick::uniform() const {
  LightPick other = *this;
  if (!empty()) other.set_picker(std::vector<float>(picker_.size(), 1.0f));
  return other;
}

void LightPick::set_brightest(float radius) {
  for (const EmittingTriangle& t : triangles_)
    brightest_ = std::max(brightest_, luminance(t.emission));
  for (const PunctualLight& light : punctual_) {
    const float distance = light.kind == LightKind::kDirectional ? 1 : 0.1f * radius;
    brightest_ = std::max(brightest_, luminance(light.intensity) / (kPi * sqr(distance)));
  }
  if (environment_) brightest_ = std::max(brightest_, environment_->brightest());
}

bool LightPick::picks_uniformly() const {
  for (uint32_t i = 1; i < picker_.size(); ++i)
    if (std::abs(picker_.probability(i) / picker_.probability(0) - 1) > 1e-3f) return false;
  return true;
}

bool LightPick::sample_punctual(const PunctualLight& light, float probability, Vec3 p,
                                LightSample& out) {
  out.punctual = true;
  out.pdf_w = probability;
  if (light.kind == LightKind::kDirectional) {
    out.wi = -light.direction;
    out.distance = std::numeric_limits<float>::infinity();
    out.radiance = light.intensity;
    return true;
  }
  const Vec3 to_light = light.position - p;
  const float distance2 = dot(to_light, to_light);
  if (!(distance2 > 0)) return false;
  out.distance = std::sqrt(distance2);
  out.wi = to_light / out.distance;
  out.radiance = light.intensity_toward(-out.wi) / distance2;
  return !out.radiance.is_black();
}

bool LightPick::sample_environment(Vec2 u, LightSample& out) const {
  const EnvironmentLight::Sample s = environment_->sample(u);
  if (!(s.pdf_w > 0)) return false;
  out.wi = s.wi;
  out.distance = std::numeric_limits<float>::infinity();
  out.radiance = environment_->radiance(s.wi);
  out.pdf_w = environment_probability_ * s.pdf_w;
  return true;
}

float LightPick::pdf_w_triangle(MeshId mesh, uint32_t triangle, float distance,
                                float abs_cos_light) const {
  const EmittingTriangle& t = triangles_[first_of_mesh_[mesh.value] + triangle];
  return t.pick_probability * sqr(distance) / (abs_cos_light * t.area);
}

}  // namespace qray
