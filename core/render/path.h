// Paths: unidirectional path tracing with next event estimation and multiple importance sampling
// (Veach 1997, power heuristic), directions drawn from the BSDF, the guide, or a mixture of both.
// Eight are under way at a time, side by side (path_lanes.h). One PathTracer per worker thread.
#pragma once

#include "core/guide/guide.h"
#include "core/math/sampler.h"
#include "core/render/light_learner.h"
#include "core/render/light_split.h"
#include "core/render/path_counters.h"
#include "core/render/path_lanes.h"
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

  // Adds the radiance arriving at the ray's origin along it to `pixel`, by flush() at the latest.
  // A sample that is not finite adds nothing and is counted. When `learn` is given, the path's
  // scattering events are recorded there by flush(). The sampler's next numbers are the path's.
  // `pixel_deviation`: of a sample of this pixel, about; 0: not known.
  void sample(const Ray& ray, const Sampler& sampler, GuideDelta* learn, float pixel_deviation,
              PixelTarget pixel);
  void flush();
  void discard();  // instead of flush()

  // Whether paths that start from now on draw from the guide, and whether it learns from them.
  void set_guiding(bool guided, bool learning) {
    guiding_ = !guide_    ? Guiding::kOff
               : guided   ? Guiding::kOn
               : learning ? Guiding::kWatch
                          : Guiding::kOff;
  }

  // What lights and the environment show of themselves to the camera is left out: it is known
  // without samples.
  void hide_lights_seen_directly() { hides_lights_ = true; }

  const PathCounters& counters() const { return counters_; }

 private:
  // A step of every path in flight, and its stages. Sets of lanes are bits; what comes back are
  // those whose paths go on.
  void advance();
  uint32_t intersect(uint32_t lanes);
  uint32_t arrive(uint32_t lanes);
  uint32_t choose_lights(uint32_t lanes);
  void make_vertices(uint32_t lanes);
  uint32_t add_direct_light(uint32_t lanes, uint32_t lit);
  uint32_t survive(uint32_t lanes);
  uint32_t scatter(uint32_t lanes);
  void go_on(uint32_t lanes);
  void finish(int lane);
  void trace_shadow_rays();

  // Parts of arrive().
  void add_environment(int lane);
  void absorb(int lane, float distance);
  void add_emission(int lane, const MeshShading& mesh, const SurfacePoint& surface);
  bool hides_lights_to(int lane) const {
    return hides_lights_ && path_.depth[index(lane)] == 1 && path_.reach[lane] == 0;
  }
  const MaterialShading& material_at(int lane, Vec3 wo, SurfacePoint& surface) const;
  bool is_lambert(int lane, const MaterialShading& material) const;

  // Parts of make_vertices().
  void find_in_guide(uint32_t lanes);
  void make_vertex(int lane);
  void ask_guide(int lane);
  void ask_guide_at_lambert(int lane);
  void tell_learner(int lane, const GuidedSurface& surface, Rgb albedo);
  bool leave_by_pane(int lane);
  Rgb pane_correction(int lane, const PathVertex& v) const;
  // Has it met as many surfaces as it may? Panes that it goes straight through do not count.
  bool at_most(int lane) const { return path_.depth[index(lane)] >= settings_.max_depth; }

  // Parts of add_direct_light().
  uint32_t choose_points(uint32_t lanes);
  uint32_t choose_on_triangles(uint32_t lanes);
  uint32_t scatter_light(uint32_t lanes);
  uint32_t weigh_light(uint32_t lanes);
  void aim_at_lights();
  void await(int lane, Rgb arriving);
  float mixture_pdf_w(const PathVertex& v, Vec3 wi, float bsdf_pdf_w, float base_pdf_w);

  // Parts of survive(). A path goes on with probability `chance`; `control` is paid to one that
  // ends, and paid back by one that goes on: the mean is the same whatever it is.
  Wide chance_by_throughput(const Wide& scale) const;
  uint32_t survive_by_noise(uint32_t lanes, Wide& chance, RgbLanes& control);

  // Parts of scatter(). False: the BSDF absorbs the path, whatever direction it might have taken.
  bool scatter_one(int lane);
  void scatter_lambert(uint32_t lanes);
  void scatter_lambert_by_guide(uint32_t lanes);
  void tell_learner_of_lambert(uint32_t lanes);
  bool scatter(const PathVertex& v, float u_lobe, Vec2 u_direction, ScatterSample& next);
  bool scatter_by_bsdf_or_guide(const PathVertex& v, float u_lobe, Vec2 u_direction,
                                ScatterSample& next);
  void scatter_by_bsdf(const PathVertex& v, const BsdfSample& s, ScatterSample& next);
  void scatter_to_caustics(const PathVertex& v, Vec2 u_direction, ScatterSample& next);
  void scatter_by_guide(const PathVertex& v, Vec2 u_direction, ScatterSample& next);
  void go_straight(int lane);

  // The layers that light of the source, scattered so often, goes into; -1: into none.
  struct LayersOf {
    int bounce = -1, group = -1;
  };
  LayersOf layers_of(int scattered, uint32_t source) const;
  bool has_groups() const { return split_ && split_->layers.groups > 0; }
  void pay_by_layer(int lane, int scattered, uint32_t source, Rgb light);

  static size_t index(int lane) { return static_cast<size_t>(lane); }
  PathLearner& learner(int lane) { return learners_[index(lane)]; }

  const PreparedScene& scene_;
  const LightPick& lights_;
  const RenderSettings& settings_;
  const bool connects_;  // surfaces to lights
  const bool textured_;
  const PixelCone pixel_;
  const GuideSampler* guide_;
  const bool guide_expects_;
  Guiding guiding_;            // of paths that start
  bool hides_lights_ = false;  // from the camera
  PathCounters counters_;
  uint64_t steps_ = 0;
  bool timed_ = false;  // the step under way is
  PathLanes path_;
  VertexLanes vertex_;
  LightLanes light_;
  std::vector<PathLearner> learners_;  // by lane
  LightLearner light_learner_;
  ShadowRays shadow_rays_;
  const LightSplit* split_;
  const CausticMap* caustics_;
  struct Paid {
    int layer;
    Rgb light;
  };
  std::array<std::vector<Paid>, kWidth> paid_;  // of the paths under way
};

}  // namespace qray
