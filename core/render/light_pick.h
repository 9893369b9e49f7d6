// Picks a point of a light for next event estimation: emitting triangles and spheres, lights
// without an extent, and the environment as one light more. Where lights are few, they are picked
// by power; many, by what they send to the point, with the environment and directional lights
// beside the tree by their power. Immutable after build; any thread.
#pragma once

#include <memory>
#include <vector>

#include "core/accel/embree_scene.h"
#include "core/math/distribution.h"
#include "core/math/warp.h"
#include "core/render/environment_light.h"
#include "core/render/light_tree.h"
#include "core/render/material_textures.h"
#include "core/scene/scene.h"

namespace qray {

struct LightSample {
  Vec3 wi;                // unit, from the shaded point to the light
  float distance = 0;     // metres; infinite for the environment
  Rgb radiance;           // that arrives if nothing is in the way; punctual: irradiance facing it
  float pdf_w = 0;        // per steradian, the choice of light counted; punctual: of it alone
  bool punctual = false;  // no other sampling finds it
  bool varies = false;    // over the light: `radiance` is to be looked up at the point
  uint32_t source = 0;    // the light's number (light_split.h)
  MeshId mesh;            // not valid: the environment
  uint32_t triangle = 0;
  Vec2 barycentric;  // of a sphere: uv
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
  bool has_tree() const { return tree_ != nullptr; }
  bool has_punctual() const { return !punctual_.empty(); }

  // False: this choice of light sends nothing to the point (it faces away).
  bool sample(const LightReceiver& at, float u_light, Vec2 u, LightSample& out) const {
    if (tree_) return sample_by_tree(at, u_light, u, out);
    return sample_of(picker_.sample(u_light), at.p, u, out);
  }
  // Density with which sample() makes the direction that hits an emitting triangle or sphere.
  // `cos_light`: of that direction's opposite with the front's normal.
  float pdf_w_of_hit(const LightReceiver& at, const Hit& hit, float cos_light) const;
  EnvironmentLight::Arriving from_environment(Vec3 wi) const {
    const EnvironmentLight::Arriving a = environment_->at(wi);
    return {a.radiance, environment_probability_ * a.pdf_w};
  }
  uint32_t environment_source() const { return environment_source_; }  // LightSample::source
  Rgb environment_radiance(Vec3 wi) const { return environment_->radiance(wi); }
  bool has_environment() const { return environment_ != nullptr; }

 private:
  void set_picker(std::span<const float> weights);
  void set_tree(std::span<const float> powers);
  void set_brightest(float radius);

  struct EmittingTriangle {
    Vec3 p0, e1, e2;  // a vertex and two edges
    Vec3 n;           // unit, front
    float area = 0;
    Rgb emission;
    float brightness = 0;  // luminance of a side, the mean over it
    bool two_sided = false, varies = false;
    MeshId mesh;
    uint32_t index = 0;  // in its mesh
  };
  // From outside, what is seen of it is drawn by solid angle; from inside, points by area.
  struct EmittingSphere {
    Sphere shape;
    Rgb emission;
    float brightness = 0;  // as a triangle's
    bool two_sided = false, varies = false;
    MeshId mesh;

    bool has_inside(Vec3 p) const {
      return dot(p - shape.center, p - shape.center) < sqr(shape.radius);
    }
    bool emits_to(bool inside) const { return two_sided || inside == shape.inward; }
    float area() const { return 4 * kPi * sqr(shape.radius); }
  };
  bool sample_of(AliasTable::Pick pick, Vec3 p, Vec2 u, LightSample& out) const {
    if (pick.index < triangles_.size())
      return sample_triangle(triangles_[pick.index], pick.probability, p, u, out);
    size_t rest = pick.index - triangles_.size();
    if (rest < spheres_.size()) return sample_sphere(spheres_[rest], pick.probability, p, u, out);
    rest -= spheres_.size();
    if (rest == punctual_.size()) return sample_environment(u, out);
    out.source = punctual_sources_[rest];
    return sample_punctual(punctual_[rest], pick.probability, p, out);
  }
  bool sample_by_tree(const LightReceiver& at, float u_light, Vec2 u, LightSample& out) const;
  static LightBounds bounds_of(const EmittingTriangle& t);
  static LightBounds bounds_of(const EmittingSphere& s);
  static bool sample_sphere(const EmittingSphere& s, float probability, Vec3 p, Vec2 u,
                            LightSample& out);
  static bool sample_triangle(const EmittingTriangle& t, float probability, Vec3 p, Vec2 u,
                              LightSample& out) {
    const Vec2 b = square_to_triangle(u);
    const Vec3 to_light = t.p0 + t.e1 * b.x + t.e2 * b.y - p;
    const float distance2 = dot(to_light, to_light);
    out.distance = std::sqrt(distance2);
    out.wi = to_light / out.distance;
    const float cos_light = -dot(out.wi, t.n);
    if (!(t.two_sided ? cos_light != 0 : cos_light > 0) || !(distance2 > 0)) return false;
    out.radiance = t.emission;
    out.source = t.mesh.value;
    if (t.varies) out.varies = true, out.mesh = t.mesh, out.triangle = t.index, out.barycentric = b;
    out.pdf_w = probability * distance2 / (std::abs(cos_light) * t.area);
    return true;
  }
  static bool sample_punctual(const PunctualLight& light, float probability, Vec3 p,
                              LightSample& out);
  bool sample_environment(Vec2 u, LightSample& out) const;

  std::vector<EmittingTriangle> triangles_;
  std::vector<EmittingSphere> spheres_;
  std::vector<uint32_t> first_of_mesh_;  // by Hit::mesh: the light of its first triangle, or none
  std::vector<PunctualLight> punctual_;  // those that have a place first
  std::vector<uint32_t> punctual_sources_;  // parallel: LightSample::source
  uint32_t environment_source_ = 0;
  std::shared_ptr<const EnvironmentLight> environment_;  // null: none
  // Triangles, spheres, punctual lights, then the environment; empty: no light at all.
  AliasTable picker_;
  // Null: lights are picked by picker_. Else those that have a place are picked by the tree with
  // its probability, the rest by `outside_`.
  std::shared_ptr<const LightTree> tree_;
  float tree_probability_ = 1;
  size_t in_tree_ = 0;
  AliasTable outside_;
  float environment_probability_ = 0;
  float brightest_ = 0;
};

}  // namespace qray
