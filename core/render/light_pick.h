// Picks a point of a light for next event estimation: emitting triangles and spheres, lights
// without an extent, and the environment as one light more. Where lights are few, they are picked
// by power; many, by what they send to the point, with the environment and directional lights
// beside the tree by their power. Where it is known how much clusters of the lights send to a place
// (light_importance.h), that counts as well. Immutable after build; any thread.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/accel/embree_scene.h"
#include "core/guide/light_clusters.h"
#include "core/math/distribution.h"
#include "core/math/warp.h"
#include "core/render/environment_light.h"
#include "core/render/light_tree.h"
#include "core/render/material_textures.h"
#include "core/scene/scene.h"

namespace qray {

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

struct LightSample {
  Vec3 wi;                // unit, from the shaded point to the light
  float distance = 0;     // metres; infinite for the environment
  Rgb radiance;           // that arrives if nothing is in the way; punctual: irradiance facing it
  float pdf_w = 0;        // per steradian, the choice of light counted; punctual: of it alone
  bool punctual = false;  // no other sampling finds it
  bool varies = false;    // over its mesh: `radiance` is to be looked up at the point
  uint32_t source = 0;    // the light's number (light_split.h)
  MeshId mesh;
  uint32_t triangle = 0;
  Vec2 barycentric;  // of a sphere: uv
  // The clusters that were picked on the way to it, or until none was left that sends anything.
  std::array<ClusterPick, 3> clusters;
  uint32_t cluster_count = 0;

  // choose() alone: a light of the tree is still to be searched, a point on the triangle to be
  // drawn, or a direction of the environment to be finished. pdf_w is then the probability that the
  // tree or this light is picked.
  bool in_tree = false;
  const EmittingTriangle* on = nullptr;
  EnvironmentLight::Drawn drawn;

  std::span<const ClusterPick> picked() const { return {clusters.data(), cluster_count}; }
  void add(ClusterPick pick) { clusters[cluster_count++] = pick; }
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
  bool empty() const { return !connects() && !environment_; }
  // Is there any light that sample() may pick? Not an even environment.
  bool connects() const { return picker_.size() > 0; }
  bool has_tree() const { return tree_ != nullptr; }
  bool has_punctual() const { return !punctual_.empty(); }

  // What LightImportance can tell apart here: no groups where there is one light alone. And its
  // weights, as long as nothing is known.
  const LightClusters& clusters() const { return clusters_; }
  const float* plain_weights() const { return plain_weights_.data(); }

  // False: this choice of light sends nothing to the point (it faces away). `weights`: of
  // clusters(), as LightImportance has them for the place; null: they are not asked for.
  bool sample(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
              const float* weights = nullptr) const {
    LightTree::Search search;
    bool sends = choose(at, u_light, u, out, weights, search);
    if (out.in_tree) {
      tree_->run({&search, 1}, 1);
      sends = finish_search(search, u, out);
    }
    if (!sends) return false;
    if (out.drawn.exists()) return finish_environment(out);
    return !out.on || sample_triangle(*out.on, out.pdf_w, at.p, u, out);
  }
  // The same, but for what many may then do side by side: searches of the tree, points on
  // triangles, and the end of what is drawn from the environment. `search`: set where a light of
  // the tree is still to be searched, which goes before the rest.
  bool choose(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
              const float* weights, LightTree::Search& search) const {
    if (weights) return choose_by_clusters(at, u_light, u, out, weights, search);
    if (tree_) return choose_by_tree(at, u_light, u, out, search);
    return sample_of(picker_.sample(u_light), at, u, out);
  }
  const LightTree& tree() const { return *tree_; }
  // The search is over: what choose() would have said of the light.
  bool finish_search(const LightTree::Search& search, Vec2 u, LightSample& out) const;
  // A ray that a light sends, lights by their power. None: the light picked has no extent, so that
  // no path meets it. `bounds`: of the scene, into which the environment sends.
  std::optional<Ray> emit(float u_light, float u_side, Vec2 u_point, Vec2 u_direction,
                          const Bounds3& bounds) const;
  // Density with which sample() makes the direction that hits an emitting triangle or sphere.
  // `cos_light`: of that direction's opposite with the front's normal.
  float pdf_w_of_hit(const LightReceiver& at, const Hit& hit, float cos_light,
                     const float* weights = nullptr) const;
  // What choose() left: sets direction, radiance and density. False: nothing comes from there.
  bool finish_environment(LightSample& s) const;
  const EnvironmentLight& environment() const { return *environment_; }
  EnvironmentLight::Arriving from_environment(Vec3 wi, const float* weights = nullptr) const;
  uint32_t environment_source() const { return environment_source_; }  // LightSample::source
  Rgb environment_radiance(Vec3 wi) const { return environment_->radiance(wi); }
  bool has_environment() const { return environment_ != nullptr; }

 private:
  void set_picker(std::span<const float> weights);
  void set_tree(std::span<const float> powers, float together);  // metres
  void set_brightest(float radius);
  void set_clusters(const Bounds3& bounds, std::span<const float> powers);
  bool choose_by_clusters(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
                          const float* weights, LightTree::Search& search) const;
  bool choose_by_tree(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
                      LightTree::Search& search) const;
  bool sample_cell(float probability, Vec3 normal, Vec2 u_point, LightSample& out,
                   const float* chances) const;
  // Lights as one picks among them: the tree as one, first, then what is not in it.
  size_t members() const { return tree_ ? 1 + outside_.size() : picker_.size(); }
  float member_prior(uint32_t member) const;
  float member_chance(uint32_t member, const float* weights) const;

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
  bool sample_of(AliasTable::Pick pick, const LightReceiver& at, Vec2 u, LightSample& out) const {
    if (pick.index < triangles_.size()) {
      out.on = &triangles_[pick.index];
      out.pdf_w = pick.probability;
      return true;
    }
    size_t rest = pick.index - triangles_.size();
    if (rest < spheres_.size())
      return sample_sphere(spheres_[rest], pick.probability, at.p, u, out);
    rest -= spheres_.size();
    if (rest == punctual_.size())
      return put_environment(environment_->draw(u, at.n), pick.probability, out);
    out.source = punctual_sources_[rest];
    return sample_punctual(punctual_[rest], pick.probability, at.p, out);
  }
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
  bool put_environment(const EnvironmentLight::Drawn& drawn, float probability,
                       LightSample& out) const;

  std::vector<EmittingTriangle> triangles_;
  std::vector<EmittingSphere> spheres_;
  std::vector<uint32_t> first_of_mesh_;  // by Hit::mesh: the light of its first triangle, or none
  std::vector<PunctualLight> punctual_;  // those that have a place first
  std::vector<uint32_t> punctual_sources_;  // parallel: LightSample::source
  uint32_t environment_source_ = 0;
  std::shared_ptr<const EnvironmentLight> environment_;  // null: none
  // Triangles, spheres, punctual lights, then the environment unless it is even.
  AliasTable picker_;
  // Null: lights are picked by picker_. Else those that have a place are picked by the tree with
  // its probability, the rest by `outside_`.
  std::shared_ptr<const LightTree> tree_;
  float tree_probability_ = 1;
  size_t in_tree_ = 0;
  AliasTable outside_;
  float environment_probability_ = 0;
  float brightest_ = 0;
  // Groups, where they are: which light, or the tree as one; the tree's; the environment's cells.
  LightClusters clusters_;
  std::vector<float> plain_weights_;
  static constexpr uint32_t kNone = ~0u;
  // The first cluster of each; kNone: there are none.
  uint32_t first_member_ = kNone, first_of_tree_ = kNone, first_cell_ = kNone;
  float member_scale_ = 0, cell_scale_ = 0;  // 1 / the light that is expected of all of them
};

}  // namespace qray
