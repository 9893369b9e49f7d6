// Picks a point of a light for next event estimation, by power: emitting triangles, lights without
// an extent, and the environment as one light more. Immutable after build; any thread.
#pragma once

#include <memory>
#include <vector>

#include "core/math/distribution.h"
#include "core/math/warp.h"
#include "core/render/environment_light.h"
#include "core/render/material_textures.h"
#include "core/scene/scene.h"

namespace qray {

struct LightSample {
  Vec3 wi;                // unit, from the shaded point to the light
  float distance = 0;     // metres; infinite for the environment
  Rgb radiance;           // that arrives if nothing is in the way; punctual: irradiance facing it
  float pdf_w = 0;        // per steradian, the choice of light counted; punctual: of it alone
  bool punctual = false;  // no other sampling finds it
  bool varies = false;    // over the triangle: `radiance` is to be looked up at the point
  MeshId mesh;
  uint32_t triangle = 0;
  Vec2 barycentric;
};

class LightPick {
 public:
  // `scene` outlives this.
  void build(const Scene& scene, const Bounds3& bounds, const MaterialTextures& textures);
  // The same lights, each picked as often as any other.
  LightPick uniform() const;
  bool picks_uniformly() const;  // are all picked alike, by their power or by uniform()?
  // Luminance emitted by any light; of a punctual one, what a white surface at a tenth of the
  // scene's radius would send on.
  float brightest() const { return brightest_; }
  bool empty() const { return picker_.size() == 0; }
  bool has_punctual() const { return !punctual_.empty(); }

  // False: this choice of light sends nothing to p (it faces away).
  bool sample(Vec3 p, float u_light, Vec2 u, LightSample& out) const {
    const AliasTable::Pick pick = picker_.sample(u_light);
    if (pick.index < triangles_.size()) return sample_triangle(triangles_[pick.index], p, u, out);
    const size_t rest = pick.index - triangles_.size();
    return rest < punctual_.size() ? sample_punctual(punctual_[rest], pick.probability, p, out)
                                   : sample_environment(u, out);
  }
  // Density with which sample() makes the direction that hits an emitting triangle, or escapes.
  float pdf_w_triangle(MeshId mesh, uint32_t triangle, float distance, float abs_cos_light) const;
  float pdf_w_environment(Vec3 wi) const {
    return environment_probability_ * environment_->pdf_w(wi);
  }
  Rgb environment_radiance(Vec3 wi) const { return environment_->radiance(wi); }
  bool has_environment() const { return environment_ != nullptr; }

 private:
  void set_picker(std::span<const float> weights);
  void set_brightest(float radius);

  struct EmittingTriangle {
    Vec3 p0, e1, e2;  // a vertex and two edges
    Vec3 n;           // unit, front
    float area = 0;
    Rgb emission;
    bool two_sided = false, varies = false;
    MeshId mesh;
    uint32_t index = 0;  // in its mesh
    float pick_probability = 0;
  };
  static bool sample_triangle(const EmittingTriangle& t, Vec3 p, Vec2 u, LightSample& out) {
    const Vec2 b = square_to_triangle(u);
    const Vec3 to_light = t.p0 + t.e1 * b.x + t.e2 * b.y - p;
    const float distance2 = dot(to_light, to_light);
    out.distance = std::sqrt(distance2);
    out.wi = to_light / out.distance;
    const float cos_light = -dot(out.wi, t.n);
    if (!(t.two_sided ? cos_light != 0 : cos_light > 0) || !(distance2 > 0)) return false;
    out.radiance = t.emission;
    if (t.varies) out.varies = true, out.mesh = t.mesh, out.triangle = t.index, out.barycentric = b;
    out.pdf_w = t.pick_probability * distance2 / (std::abs(cos_light) * t.area);
    return true;
  }
  static bool sample_punctual(const PunctualLight& light, float probability, Vec3 p,
                              LightSample& out);
  bool sample_environment(Vec2 u, LightSample& out) const;

  std::vector<EmittingTriangle> triangles_;
  std::vector<uint32_t> first_of_mesh_;  // by Hit::mesh: index of its first triangle, or none
  std::vector<PunctualLight> punctual_;
  std::shared_ptr<const EnvironmentLight> environment_;  // null: none
  AliasTable picker_;  // triangles, punctual lights, then the environment; empty: no light at all
  float environment_probability_ = 0;
  float brightest_ = 0;
};

}  // namespace qray
