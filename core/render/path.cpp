#include "core/render/path.h"

#include <cmath>

#include "core/base/cycle_clock.h"
#include "core/bsdf/diffuse.h"
#include "core/math/frame.h"
#include "core/scene/surface.h"

namespace qray {
namespace {

constexpr uint64_t kTimedEvery = 64;
constexpr size_t kRaysAtOnce = 1024;
// A scattered ray stands for a cone of its share of the sphere; textures are averaged over a tenth
// of that across.
constexpr float kSpreadOfScattering = 0.1f, kWidestSpread = 0.3f;  // radians
constexpr float kLeastSurvival = 0.05f;
// The root of the cost of a path so far over that of its going on, were noises known exactly (Rath
// et al. 2022); they are not: see docs/guiding.md.
constexpr float kRouletteFactor = 4;

// Adds the cycles of a scope to `total` when `on`.
class CycleScope {
 public:
  CycleScope(bool on, uint64_t& total) : total_(on ? &total : nullptr) {
    if (total_) start_ = cycle_count();
  }
  ~CycleScope() {
    if (total_) *total_ += cycle_count() - start_;
  }
  CycleScope(const CycleScope&) = delete;
  CycleScope& operator=(const CycleScope&) = delete;

 private:
  uint64_t* total_;
  uint64_t start_ = 0;
};

// Beer and Lambert's law.
Rgb transmittance(Rgb absorption, float distance) {
  return {std::exp(-absorption.r * distance), std::exp(-absorption.g * distance),
          std::exp(-absorption.b * distance)};
}

float power_heuristic(float pdf, float other_pdf) {
  const float ratio = other_pdf / pdf;  // of densities, so that their squares cannot overflow
  return 1 / (1 + ratio * ratio);
}

}  // namespace

// A surface on the path, seen from wo.
struct PathTracer::Vertex {
  SurfacePoint surface;
  Frame frame;  // about the shading normal
  Vec3 wo;      // local, to the previous vertex
  const Bsdf& bsdf;
  BsdfKind kind;
  ShadingPoint sp;
  float ray_offset;  // metres off the surface where rays may start
  const MaterialShading& material;
  const Rgb* inside;  // absorption where the path comes from; null: none
  GuidePoint at;
  float guide_fraction;

  // Lambert surfaces are called directly, which the compiler can inline.
  BsdfEval eval(Vec3 wi) const {
    return kind == BsdfKind::kDiffuse ? Diffuse::eval_at(sp, wo, wi) : bsdf.eval(sp, wo, wi);
  }
  std::optional<BsdfSample> sample(float u_lobe, Vec2 u) const {
    return kind == BsdfKind::kDiffuse ? Diffuse::sample_at(sp, wo, u)
                                      : bsdf.sample(sp, wo, u_lobe, u);
  }
  // Both normals must agree on which side a direction lies, or light leaks through the surface.
  bool sides_agree(Vec3 wi, Vec3 wi_local) const { return dot(wi, surface.ng) * wi_local.z > 0; }
  // What a ray that leaves along wi passes through: beyond a solid's boundary its inside or, coming
  // from there, the open (solids within solids are not kept apart).
  const Rgb* inside_along(Vec3 wi) const {
    const bool inward = dot(wi, surface.ng) < 0;
    if (!material.bounds_solid || inward == (dot(frame.to_world(wo), surface.ng) < 0))
      return inside;
    return inward && !material.material->absorption.is_black() ? &material.material->absorption
                                                               : nullptr;
  }
  Vec3 ray_origin(Vec3 wi) const {
    return surface.p + surface.ng * std::copysign(ray_offset, dot(surface.ng, wi));
  }
};

PathCounters& PathCounters::operator+=(const PathCounters& o) {
  paths += o.paths;
  rays += o.rays;
  lookups += o.lookups;
  dropped_samples += o.dropped_samples;
  timed_total += o.timed_total;
  timed_tracing += o.timed_tracing;
  timed_guiding += o.timed_guiding;
  return *this;
}

PathTracer::PathTracer(const PreparedScene& scene, const LightPick& lights,
                       const RenderSettings& settings, const Guide* guide)
    : scene_(scene),
      lights_(lights),
      settings_(settings),
      connects_(!lights.empty() && (settings.nee || lights.has_punctual())),
      textured_(!scene.textures->empty()),
      pixel_angle_(
          CameraRays(settings.camera.value_or(scene.scene.camera), settings.width, settings.height)
              .pixel_angle()),
      guide_(guide),
      guide_expects_(guide && guide->expects()),
      learner_(guide) {}

void PathTracer::sample(const Ray& ray, Sampler& sampler, GuideDelta* learn, float pixel_deviation,
                        Rgb& pixel) {
  timed_ = counters_.paths++ % kTimedEvery == 0;
  const CycleScope scope(timed_, counters_.timed_total);
  learner_.begin(learn);
  const Rgb radiance = walk(ray, sampler, pixel_deviation, pixel);
  learner_.end();
  if (is_finite(radiance)) {
    pixel += radiance;
  } else {
    ++counters_.dropped_samples;
  }
  if (waiting_.size() >= kRaysAtOnce) flush();
}

inline bool PathTracer::intersect(const Ray& ray, Hit& hit) {
  ++counters_.rays;
  const CycleScope scope(timed_, counters_.timed_tracing);
  return scene_.accel->intersect(ray, hit);
}

void PathTracer::flush() {
  const uint64_t start = cycle_count();
  if (!waiting_.empty()) scene_.accel->occluded(waiting_rays_);
  const uint64_t traced = cycle_count();
  counters_.rays += waiting_rays_.size();
  for (size_t i = 0; i < waiting_.size(); ++i) {
    const Waiting& w = waiting_[i];
    if (waiting_rays_[i].occluded()) continue;
    *w.pixel += w.light;
    if (w.vertex != PathLearner::kNoVertex) learner_.direct(w.vertex, w.scattered, w.punctual);
  }
  waiting_.clear();
  waiting_rays_.clear();
  learner_.flush();
  // As paths are timed: one in many.
  const uint64_t learned = cycle_count();
  counters_.timed_tracing += (traced - start) / kTimedEvery;
  counters_.timed_guiding += (learned - traced) / kTimedEvery;
  counters_.timed_total += (learned - start) / kTimedEvery;
}

void PathTracer::discard() {
  waiting_.clear();
  waiting_rays_.clear();
  learner_.discard();
}

inline float PathTracer::mixture_pdf_w(const Vertex& v, Vec3 wi, float bsdf_pdf_w) {
  if (v.guide_fraction == 0) return bsdf_pdf_w;
  const CycleScope guiding(timed_, counters_.timed_guiding);
  return lerp(v.guide_fraction, bsdf_pdf_w, guide_->pdf_w(v.at, wi));
}

// More than the rounding noise of o + t d and of the largest triangle's coordinates.
inline float PathTracer::ray_offset(Vec3 p, float t) const {
  const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), t});
  return std::max(largest * kRayOffset, scene_.ray_epsilon);
}

// Light from a point of a light, should nothing be in between; black: none.
inline PathTracer::Connection PathTracer::connect(const Vertex& v, Vec2 u, float u_light) {
  LightSample light;
  if (!lights_.sample(v.surface.p, u_light, u, light)) return {};
  if (!settings_.nee && !light.punctual) return {};
  const Vec3 wi_local = v.frame.to_local(light.wi);
  if (!v.sides_agree(light.wi, wi_local)) return {};
  const BsdfEval eval = v.eval(wi_local);
  if (eval.f_cos.is_black()) return {};
  if (light.varies)
    light.radiance = scene_.emission_at(light.mesh, light.triangle, light.barycentric);
  if (const Rgb* inside = v.inside_along(light.wi); inside && std::isfinite(light.distance))
    light.radiance *= transmittance(*inside, light.distance);
  const float ratio = light.punctual ? 0 : mixture_pdf_w(v, light.wi, eval.pdf_w) / light.pdf_w;
  const float mis_over_pdf = 1 / (light.pdf_w * (1 + ratio * ratio));  // the power heuristic
  // The ray starts off the surface, perhaps nearer to the light, and must end before it.
  const float t_max = std::min(light.distance * (1 - 1e-4f), light.distance - 2 * v.ray_offset);
  return {eval.f_cos * light.radiance * mis_over_pdf,
          {v.ray_origin(light.wi), light.wi, std::max(t_max, 0.0f)},
          light.punctual};
}

// Russian roulette. Where the table is credible, by the noise that what follows would bring into
// the pixel, with the table's expectation as control variate (after Rath et al. 2022, "EARS", and
// Mueller et al. 2020, "Neural Control Variates"); else by throughput from some depth on.
inline PathTracer::Survival PathTracer::survival(const Vertex& v, Rgb throughput,
                                                 float pixel_deviation, int depth) {
  if (guide_expects_ && guiding_ != Guiding::kOff && v.kind == BsdfKind::kDiffuse) {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    const GuideExpectation expected = guide_->expectation(v.at);
    if (expected.credible) {
      const Rgb control = v.sp.reflectance * expected.arriving;
      if (learner_.on()) learner_.expected(control);
      if (guiding_ == Guiding::kOn) {
        if (!settings_.russian_roulette || !(pixel_deviation > 0)) return {};
        const float noise =
            kRouletteFactor * luminance(throughput * v.sp.reflectance) * expected.deviation;
        return {std::clamp(noise / pixel_deviation, kLeastSurvival, 1.0f), control};
      }
    }
  }
  if (!settings_.russian_roulette || depth < kRouletteFromDepth) return {};
  return {std::min(0.95f, max_component(throughput)), {}};
}

// Chooses wi_ with weight_, pdf_w_ and delta_. False: the path ends here.
inline bool PathTracer::scatter(const Vertex& v, float u_lobe, Vec2 u) {
  delta_ = false;
  if (u_lobe < v.guide_fraction) {
    float guide_pdf_w;
    {
      const CycleScope guiding(timed_, counters_.timed_guiding);
      const GuideSample s = guide_->sample(v.at, u);
      wi_ = s.wi;
      guide_pdf_w = s.pdf_w;
    }
    const Vec3 wi_local = v.frame.to_local(wi_);
    const BsdfEval eval = v.eval(wi_local);
    bsdf_pdf_w_ = eval.pdf_w;
    pdf_w_ = lerp(v.guide_fraction, eval.pdf_w, guide_pdf_w);
    if (eval.f_cos.is_black() || !v.sides_agree(wi_, wi_local)) return false;
    weight_ = eval.f_cos / pdf_w_;
    return true;
  }
  if (v.guide_fraction > 0) u_lobe = (u_lobe - v.guide_fraction) / (1 - v.guide_fraction);
  const std::optional<BsdfSample> s = v.sample(u_lobe, u);
  if (!s) {
    delta_ = true;  // nothing to learn from
    return false;
  }
  wi_ = v.frame.to_world(s->wi);
  delta_ = s->delta;
  weight_ = s->weight;
  pdf_w_ = bsdf_pdf_w_ = s->pdf_w;
  if (delta_) {
    weight_ *= 1 / (1 - v.guide_fraction);
  } else if (v.guide_fraction > 0) {
    pdf_w_ = mixture_pdf_w(v, wi_, s->pdf_w);
    weight_ *= s->pdf_w / pdf_w_;
  }
  return v.sides_agree(wi_, s->wi) && !weight_.is_black();
}

Rgb PathTracer::walk(Ray ray, Sampler& sampler, float pixel_deviation, Rgb& pixel) {
  if (lights_.empty()) return {};  // black, whatever the path
  Rgb radiance, throughput{1.0f};
  const Rgb* inside = nullptr;             // absorption along the ray; null: none
  delta_ = true;                           // nee cannot make the camera's ray
  float width = 0, spread = pixel_angle_;  // metres that the ray stands for, and more each metre
  for (int depth = 1;; ++depth) {
    // Drawn before the ray is traced: the processor then does both at once.
    const Sampler::Pairs u = sampler.next_pairs();
    Hit hit;
    if (!intersect(ray, hit)) {
      // 1a. The environment, weighted against nee having drawn this direction.
      if (lights_.has_environment() && !(hides_lights_ && depth == 1)) {
        const Rgb emitted = lights_.environment_radiance(ray.d);
        const float mis = delta_ || !settings_.nee
                              ? 1.0f
                              : power_heuristic(pdf_w_, lights_.pdf_w_environment(ray.d));
        radiance += throughput * emitted * mis;
        learner_.emitted(emitted, mis);
      }
      return radiance;
    }
    const MeshShading& mesh = scene_.meshes[hit.mesh.value];
    if (textured_) width += spread * hit.t;
    SurfacePoint surface = scene_.surface_at(ray, hit, width);
    const Vec3 wo = -ray.d;
    const float cos_geometric = dot(wo, surface.ng);

    if (inside) {
      const Rgb kept = transmittance(*inside, hit.t);
      throughput *= kept;
      learner_.attenuated(kept);
    }

    // 1b. Light that the surface emits.
    if (mesh.emits && (cos_geometric > 0 || mesh.material->emission_two_sided) &&
        !(hides_lights_ && depth == 1)) {
      const Rgb emitted = mesh.emission_textured()
                              ? scene_.textures->color(mesh.material->emission, surface.uv)
                              : mesh.material->emission.value;
      float mis = 1;
      if (!delta_ && settings_.nee) {
        mis = power_heuristic(
            pdf_w_, lights_.pdf_w_triangle(hit.mesh, hit.triangle, hit.t, std::abs(cos_geometric)));
      }
      radiance += throughput * emitted * mis;
      learner_.emitted(emitted, mis);
    }
    if (depth >= settings_.max_depth) return radiance;

    // 2. What the surface is made of, and what the guide knows about it.
    const MaterialShading* material = &mesh;
    if (mesh.blends) {
      material = &scene_.resolve(mesh, surface.uv, u.d.y);
      if (material->bends) scene_.bend(*material, hit, wo, surface);
    }
    if (material->one_sided && cos_geometric < 0) return radiance;
    const bool shading_normal_usable = dot(wo, surface.ns) * cos_geometric > 0;
    const Frame frame(shading_normal_usable ? surface.ns : surface.ng);
    Vertex v{surface,
             frame,
             frame.to_local(wo),
             *material->bsdf,
             material->kind,
             scene_.shading_point(*material, surface),
             ray_offset(surface.p, hit.t),
             *material,
             inside,
             {},
             0};
    if (guide_ && guiding_ != Guiding::kOff && v.kind != BsdfKind::kDelta) {
      ++counters_.lookups;
      const CycleScope guiding(timed_, counters_.timed_guiding);
      v.at = guide_->find(surface.p, cos_geometric > 0 ? surface.ng : -surface.ng);
      if (guiding_ == Guiding::kOn)
        v.guide_fraction = guide_->guide_fraction(v.at, v.kind == BsdfKind::kDiffuse);
      if (learner_.on()) learner_.vertex(v.at, surface.p);
      if (learner_.on() && learner_.wants_albedo())
        learner_.albedo(
            luminance(v.kind == BsdfKind::kDiffuse ? v.sp.reflectance : v.bsdf.albedo(v.sp, v.wo)));
    }

    // 3. Light straight from a light. Its ray waits to be traced with others. Nothing else finds a
    // light without an extent.
    if (connects_ && v.kind != BsdfKind::kDelta) {
      const Connection connection = connect(v, u.a, u.c.x);
      if (!connection.light.is_black()) {
        const Rgb light = throughput * connection.light;
        if (!is_finite(light)) return light;
        waiting_.push_back(
            {light, &pixel, connection.light, learner_.current(), connection.punctual});
        waiting_rays_.emplace_back(connection.ray);
      }
    }

    // 4. Russian roulette.
    const Survival survival = this->survival(v, throughput, pixel_deviation, depth);
    float inverse_chance = 1;
    if (survival.chance < 1) {
      if (!(u.d.x < survival.chance)) return radiance + throughput * survival.control;
      inverse_chance = 1 / survival.chance;
      radiance += throughput * survival.control * (1 - inverse_chance);
      throughput *= inverse_chance;
    }

    // 5. The next direction.
    const bool scattered = scatter(v, u.c.y, u.b);
    if (delta_) {
      if (scattered) learner_.scattered_delta(v.kind != BsdfKind::kDelta, weight_ * inverse_chance);
    } else {
      learner_.scattered(wi_, pdf_w_, bsdf_pdf_w_, scattered ? weight_ : Rgb{}, inverse_chance);
    }
    if (!scattered) return radiance;
    throughput *= weight_;
    if (textured_ && !delta_)
      spread += std::min(kSpreadOfScattering / std::sqrt(pdf_w_), kWidestSpread);
    inside = v.inside_along(wi_);
    ray = {v.ray_origin(wi_), wi_};
  }
}

}  // namespace qray
