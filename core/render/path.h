// One path: unidirectional path tracing with next event estimation and multiple importance sampling
// (Veach 1997, power heuristic), directions drawn from the BSDF, the guide, or a mixture of both.
// One PathTracer per worker thread.
#pragma once

#include "core/guide/guide.h"
#include "core/math/sampler.h"
#include "core/render/light_learner.h"
#include "core/render/light_split.h"
#include "core/render/path_counters.h"
#include "core/render/path_learner.h"
#include "core/render/path_state.h"
#include "core/render/path_vertex.h"
#include "core/render/prepared_scene.h"
#include "core/render/shadow_rays.h"
#include "core/settings/render_settings.h"

namespace qray {

constexpr int kRouletteFromDepth = 5;  // surfaces on the path

class PathTracer {
 public:
  // All outlive this. `lights` are the scene's, however they are picked; `guide` may be null.
  // `split`: into which layers light goes; null: targets have none. `caustics`: at which paths aim;
  // null: at none.
  PathTracer(const PreparedScene& scene, const LightPick& lights, const RenderSettings& settings,
             const Guide* guide, const LightSplit* split = nullptr,
             const CausticMap* caustics = nullptr);

  // Adds the radiance arriving at the ray's origin along it to `pixel`, some of it only at flush():
  // rays to lights are traced many at once. A sample that is not finite adds nothing and is
  // counted. When `learn` is given, the path's scattering events are
  // recorded there by flush(). `pixel_deviation`: of a sample of this pixel, about; 0: not known.
  void sample(const Ray& ray, Sampler& sampler, GuideDelta* learn, float pixel_deviation,
              PixelTarget pixel);
  void flush();
  void discard();  // instead of flush()

  // Whether paths draw from the guide, and whether it learns from them.
  void set_guiding(bool guided, bool learning) {
    guiding_ = guided ? Guiding::kOn : learning ? Guiding::kWatch : Guiding::kOff;
  }

  // What lights and the environment show of themselves to the camera is left out: it is known
  // without samples.
  void hide_lights_seen_directly() { hides_lights_ = true; }

  const PathCounters& counters() const { return counters_; }

 private:
  // A path goes on with probability `chance`; `control` is paid to one that ends, and paid back by
  // one that goes on: the mean is the same whatever it is.
  struct Survival {
    float chance = 1;
    Rgb control;
  };
  // The steps of walk(). Those that return false end the path.
  Rgb walk(const Ray& ray, Sampler& sampler, float pixel_deviation, PixelTarget pixel);
  bool intersect(const Ray& ray, Hit& hit);
  void add_environment(PathState& path, PixelTarget pixel);
  void absorb(PathState& path, float distance);
  void add_emission(PathState& path, const Hit& hit, const SurfacePoint& surface, float cos_light,
                    PixelTarget pixel);
  bool hides_lights_to(const PathState& path) const {
    return hides_lights_ && path.depth == 1 && path.reach == 0;
  }
  const MaterialShading& material_at(const Hit& hit, Vec3 wo, SurfacePoint& surface,
                                     float u_blend) const;
  PathVertex vertex_at(const PathState& path, const MaterialShading& material, const Hit& hit,
                       const SurfacePoint& surface, Vec3 wo, ShadingPoint& room) const;
  void ask_guide(const PathState& path, PathVertex& v, bool from_front);
  bool add_direct_light(PathState& path, PathVertex& v, float u_light, Vec2 u_light_point,
                        PixelTarget pixel);
  bool survive(PathState& path, const PathVertex& v, float u_roulette);
  bool go_on(PathState& path, const PathVertex& v, const Hit& hit, float u_lobe, Vec2 u_direction);
  static void go_straight(PathState& path, const PathVertex& v, const Hit& hit);
  bool leave_by_pane(PathState& path, const PathVertex& v, const Hit& hit, float u_lobe,
                     Vec2 u_direction);
  Rgb pane_correction(const PathVertex& v, Vec3 d, const Hit& hit) const;
  // Has it met as many surfaces as it may? Panes that it goes straight through do not count.
  bool at_most(const PathState& path) const { return path.depth >= settings_.max_depth; }

  static Ray shadow_ray(const PathVertex& v, const LightSample& light);
  Survival survival(PathState& path, const PathVertex& v);
  float unguided_chance(int depth, Rgb throughput) const;  // of roulette
  // These fill `next`, which comes empty. False: the BSDF absorbs the path, whatever direction it
  // might have taken.
  bool scatter(const PathVertex& v, float u_lobe, Vec2 u_direction, ScatterSample& next);
  bool scatter_by_bsdf_or_guide(const PathVertex& v, float u_lobe, Vec2 u_direction,
                                ScatterSample& next);
  void scatter_by_bsdf(const PathVertex& v, const BsdfSample& s, ScatterSample& next);
  void scatter_to_caustics(const PathVertex& v, Vec2 u_direction, ScatterSample& next);
  void scatter_by_guide(const PathVertex& v, Vec2 u_direction, ScatterSample& next);
  float mixture_pdf_w(const PathVertex& v, Vec3 wi, float bsdf_pdf_w, float base_pdf_w);

  // The layers that light of the source, scattered so often, goes into; -1: into none.
  struct LayersOf {
    int bounce = -1, group = -1;
  };
  LayersOf layers_of(int scattered, uint32_t source) const;
  bool has_groups() const { return split_ && split_->layers.groups > 0; }
  void pay_by_layer(int scattered, uint32_t source, Rgb light);

  const PreparedScene& scene_;
  const LightPick& lights_;
  const RenderSettings& settings_;
  const bool connects_;  // surfaces to lights
  const bool textured_;
  const PixelCone pixel_;
  const GuideSampler* guide_;
  const bool guide_expects_;
  enum class Guiding { kOff, kWatch, kOn };  // kWatch only looks up, so that the guide can learn
  Guiding guiding_ = Guiding::kOn;
  bool hides_lights_ = false;  // from the camera
  PathCounters counters_;
  bool timed_ = false;  // the path under way is
  PathLearner learner_;
  LightLearner light_learner_;
  ShadowRays shadow_rays_;
  const LightSplit* split_;
  const CausticMap* caustics_;
  struct Paid {
    int layer;
    Rgb light;
  };
  std::vector<Paid> paid_;  // of the path under way
};

}  // namespace qray
