#include "core/render/path.h"

#include <cmath>
#include <new>

#include "core/base/cycle_clock.h"

namespace qray {
namespace {

constexpr uint64_t kTimedEvery = 64;
// A scattered ray stands for a cone of its share of the sphere; textures are averaged over a tenth
// of that across.
constexpr float kSpreadOfScattering = 0.1f, kWidestSpread = 0.3f;  // radians
constexpr float kLeastSurvival = 0.05f;
// The root of the cost of a path so far over that of its going on, were noises known exactly (Rath
// et al. 2022); they are not: see docs/measurements/guiding.md.
constexpr float kRouletteFactor = 4;

// Beer and Lambert's law.
Rgb transmittance(Rgb absorption, float distance) {
  return {std::exp(-absorption.r * distance), std::exp(-absorption.g * distance),
          std::exp(-absorption.b * distance)};
}

float power_heuristic(float pdf, float other_pdf) {
  return 1 / (1 + sqr(other_pdf / pdf));  // of the ratio, so that squares cannot overflow
}

}  // namespace

PathTracer::PathTracer(const PreparedScene& scene, const LightPick& lights,
                       const RenderSettings& settings, const Guide* guide, const LightSplit* split,
                       const CausticMap* caustics)
    : scene_(scene),
      lights_(lights),
      settings_(settings),
      connects_(lights.connects() && (settings.nee || lights.has_punctual())),
      textured_(!scene.textures->empty()),
      pixel_(
          CameraRays(settings.camera.value_or(scene.scene.camera), settings.width, settings.height)
              .cone()),
      guide_(guide),
      guide_expects_(guide && guide->expects()),
      learner_(guide),
      light_learner_(guide, lights),
      split_(split),
      caustics_(caustics) {}

void PathTracer::sample(const Ray& ray, Sampler& sampler, GuideDelta* learn, float pixel_deviation,
                        PixelTarget pixel) {
  timed_ = counters_.paths++ % kTimedEvery == 0;
  const bool guided = guide_ && guiding_ == Guiding::kOn;
  const uint64_t rays_before = counters_.rays;
  const CycleScope scope(timed_, counters_.timed_total);
  learner_.begin(learn, guide_expects_ ? pixel.saved : nullptr);  // others are not judged
  const Rgb radiance = walk(ray, sampler, pixel_deviation, pixel);
  learner_.end();
  if (guided) {
    ++counters_.guided_paths;
    counters_.guided_rays += counters_.rays - rays_before;
  }
  if (is_finite(radiance)) {
    pixel.radiance += radiance;
    for (const Paid& paid : paid_) pixel.layers[paid.layer] += paid.light;
  } else {
    ++counters_.dropped_samples;
  }
  paid_.clear();
  if (shadow_rays_.enough()) flush();
}

Rgb PathTracer::walk(const Ray& ray, Sampler& sampler, float pixel_deviation, PixelTarget pixel) {
  if (lights_.empty()) return {};  // black, whatever the path
  PathState path{.ray = ray,
                 .spread = pixel_.angle,
                 .width = pixel_.width,
                 .pixel_deviation = pixel_deviation};
  ShadingPoint room;
  for (;;) {
    // Drawn before the ray is traced: the processor then does both at once.
    const VertexNumbers u = VertexNumbers::draw(sampler);

    // 1. The next surface, or the way out.
    Hit hit;
    if (!intersect(path.ray, hit)) {
      add_environment(path, pixel);
      break;
    }
    if (textured_) path.width += path.spread * hit.t;
    SurfacePoint surface = scene_.surface_at(path.ray, hit, path.width);
    const Vec3 wo = -path.ray.d;
    const float cos_geometric = dot(wo, surface.ng);
    absorb(path, hit.t);

    // 2. Light that the surface emits.
    add_emission(path, hit, surface, cos_geometric, pixel);
    const MeshShading& mesh = scene_.meshes[hit.mesh.value];
    if (at_most(path) && !mesh.pane) break;

    // 3. What the surface is made of, and what the guide knows about it.
    const MaterialShading& material = material_at(hit, wo, surface, u.u_blend);
    if (material.one_sided && cos_geometric < 0) break;
    PathVertex v = vertex_at(path, material, hit, surface, wo, room);
    if (at_most(path)) {
      if (!leave_by_pane(path, v, hit, u.u_lobe, u.u_direction)) break;
      continue;
    }
    ask_guide(path, v, cos_geometric > 0);

    // 4. Light straight from a light.
    if (!add_direct_light(path, v, u.u_light, u.u_light_point, pixel)) break;

    // 5. Russian roulette, but not at panes: a path of fewer surfaces meets the last one without.
    if (!(mesh.pane && v.kind == BsdfKind::kDelta) && !survive(path, v, u.u_roulette)) break;

    // 6. The next direction.
    if (!go_on(path, v, hit, u.u_lobe, u.u_direction)) break;
  }
  return path.radiance;
}

void PathTracer::flush() {
  const uint64_t start = cycle_count();
  shadow_rays_.trace(*scene_.accel);
  const uint64_t traced = cycle_count();
  shadow_rays_.for_each_free([this](const AwaitedLight& awaited, Rgb passed) {
    const Rgb light = awaited.light * passed, scattered = awaited.scattered * passed;
    *awaited.pixel += light;
    if (awaited.layer) *awaited.layer += light;
    if (awaited.group) *awaited.group += light;
    if (awaited.vertex != PathLearner::kNoVertex)
      learner_.direct(awaited.vertex, scattered, awaited.punctual, awaited.unguided_weight);
    light_learner_.sends(awaited.pick, luminance(scattered));
  });
  shadow_rays_.clear();
  learner_.flush();
  light_learner_.flush();
  // As paths are timed: one in many.
  const uint64_t learned = cycle_count();
  counters_.timed_tracing += (traced - start) / kTimedEvery;
  counters_.timed_guiding += (learned - traced) / kTimedEvery;
  counters_.timed_total += (learned - start) / kTimedEvery;
}

void PathTracer::discard() {
  shadow_rays_.clear();
  learner_.discard();
  light_learner_.discard();
}

inline bool PathTracer::intersect(const Ray& ray, Hit& hit) {
  ++counters_.rays;
  const CycleScope scope(timed_, counters_.timed_tracing);
  return scene_.accel->intersect(ray, hit);
}

inline float PathTracer::mixture_pdf_w(const PathVertex& v, Vec3 wi, float bsdf_pdf_w,
                                       float base_pdf_w) {
  if (v.mixture.guide == 0) return v.with_caustics(wi, bsdf_pdf_w);
  const CycleScope guiding(timed_, counters_.timed_guiding);
  return v.with_caustics(
      wi, v.mixture.pdf_w(guide_->pdf_w(v.at, wi), base_pdf_w, bsdf_pdf_w - base_pdf_w));
}

// The light that a path meets where it leaves the scene, weighted against nee having drawn this
// direction.
inline void PathTracer::add_environment(PathState& path, PixelTarget pixel) {
  if (!lights_.has_environment() || hides_lights_to(path)) return;
  const auto [emitted, nee_pdf_w] = lights_.from_environment(path.ray.d, path.from_lights);
  const float mis = path.delta || !settings_.nee ? 1.0f : power_heuristic(path.pdf_w, nee_pdf_w);
  const Rgb light = path.throughput * emitted * mis;
  path.radiance += light;
  if (path.depth == 1 && pixel.seen) *pixel.seen += light;
  if (split_) pay_by_layer(path.depth - 1, lights_.environment_source(), light);
  learner_.emitted(emitted, mis);
}

inline PathTracer::LayersOf PathTracer::layers_of(int scattered, uint32_t source) const {
  LayersOf of;
  if (split_->layers.bounces > 0 && scattered > 0) of.bounce = split_->layers.bounce(scattered);
  if (split_->layers.groups > 0) of.group = split_->layers.group(split_->group_of_source[source]);
  return of;
}

// Once the path has ended as a number.
void PathTracer::pay_by_layer(int scattered, uint32_t source, Rgb light) {
  const LayersOf of = layers_of(scattered, source);
  if (of.bounce >= 0) paid_.push_back({of.bounce, light});
  if (of.group >= 0) paid_.push_back({of.group, light});
}

inline void PathTracer::absorb(PathState& path, float distance) {
  if (!path.inside) return;
  const Rgb kept = transmittance(*path.inside, distance);
  path.throughput *= kept;
  learner_.attenuated(kept);
}

// Light that the surface emits, weighted against nee having drawn this point.
inline void PathTracer::add_emission(PathState& path, const Hit& hit, const SurfacePoint& surface,
                                     float cos_light, PixelTarget pixel) {
  const MeshShading& mesh = scene_.meshes[hit.mesh.value];
  if (!mesh.emits || hides_lights_to(path)) return;
  if (!(cos_light > 0 || mesh.material->emission_two_sided)) return;
  const Rgb emitted = mesh.emission_textured()
                          ? scene_.textures->color(mesh.material->emission, surface.uv)
                          : mesh.material->emission.value;
  float mis = 1;
  if (!path.delta && settings_.nee) {
    Hit met = hit;
    met.t += path.reach;
    mis = power_heuristic(path.pdf_w,
                          lights_.pdf_w_of_hit(path.from, met, cos_light, path.from_lights));
  }
  const Rgb light = path.throughput * emitted * mis;
  path.radiance += light;
  if (path.depth == 1 && pixel.seen) *pixel.seen += light;
  if (split_) pay_by_layer(path.depth - 1, hit.mesh.value, light);
  learner_.emitted(emitted, mis);
}

// Of a blend, the part that is drawn.
inline const MaterialShading& PathTracer::material_at(const Hit& hit, Vec3 wo,
                                                      SurfacePoint& surface, float u_blend) const {
  const MeshShading& mesh = scene_.meshes[hit.mesh.value];
  if (!mesh.blends) return mesh;
  const MaterialShading& part = scene_.resolve(mesh, surface.uv, u_blend);
  if (part.bends) scene_.bend(part, hit, wo, surface);
  return part;
}

inline PathVertex PathTracer::vertex_at(const PathState& path, const MaterialShading& material,
                                        const Hit& hit, const SurfacePoint& surface, Vec3 wo,
                                        ShadingPoint& room) const {
  const Frame frame = scene_.scattering_frame(material, hit, wo, surface);
  const Vec3 wo_local = frame.to_local(wo);
  const ShadingPoint* sp = &scene_.shading_point(material, surface, room);
  if (material.coat_bends) {
    room = *sp;
    room.coat_normal = frame.to_local(scene_.coat_normal(material, hit, wo, surface));
    sp = &room;
  }
  return {.surface = surface,
          .frame = frame,
          .bsdf = *material.bsdf,
          .kind = material.kind,
          .bsdf_at = material.kind == BsdfKind::kDiffuse ? BsdfPoint(*sp, wo_local)
                                                         : material.bsdf->at(*sp, wo_local),
          .ray_offset = scene_.ray_offset(surface.p, hit.t),
          .material = material,
          .inside = path.inside,
          .receiver = {surface.p,
                       material.opaque ? frame.z * std::copysign(1.0f, wo_local.z) : Vec3{}}};
}

inline void PathTracer::ask_guide(const PathState& path, PathVertex& v, bool from_front) {
  if (v.kind == BsdfKind::kDelta) return;
  const bool asks = guide_ && guiding_ != Guiding::kOff;
  if (caustics_ || (asks && (guide_expects_ || v.kind == BsdfKind::kDiffuse))) v.find_parts();
  if (caustics_ && catches_photons(v.bsdf_at, v.parts.base_chance))
    v.caustics = caustics_->find(v.surface.p);
  if (!asks) return;
  ++counters_.lookups;
  const CycleScope guiding(timed_, counters_.timed_guiding);
  // In place: a copy of what was just written would wait for it (docs/measurements/paths.md).
  new (&v.at) GuidePoint(guide_->find(v.surface.p, from_front ? v.surface.ng : -v.surface.ng));
  if (guiding_ == Guiding::kOn) v.mixture = guide_->mixture(v.at, v.guided_surface());
  if (!learner_.on()) return;
  learner_.vertex(v.at, v.surface.p, path);
  if (learner_.wants_albedo()) learner_.albedo(luminance(v.albedo()));
  if (learner_.wants_bsdf())
    learner_.surface(v.guided_surface(), luminance(v.parts.base_albedo + v.parts.lobes_albedo));
}

// Light straight from a light, paid if its ray turns out to be free. Nothing else finds a light
// without an extent. False: it is no number, and the sample will be dropped.
inline bool PathTracer::add_direct_light(PathState& path, PathVertex& v, float u_light,
                                         Vec2 u_light_point, PixelTarget pixel) {
  if (!connects_ || v.kind == BsdfKind::kDelta) return true;
  v.lights = light_learner_.place(v.receiver, learner_.on());
  LightSample light;
  const bool sends = lights_.sample(v.receiver, u_light, u_light_point, light, v.lights.weights);
  const uint32_t pick =
      learner_.on() ? light_learner_.picked(v.lights, light) : LightLearner::kNoPick;
  if (!sends || (!settings_.nee && !light.punctual)) return true;
  const Vec3 wi_local = v.frame.to_local(light.wi);
  if (!v.sides_agree(light.wi, wi_local)) return true;
  const BsdfEval eval = v.eval(wi_local);
  if (eval.f_cos.is_black()) return true;
  if (light.varies) {
    light.radiance = light.mesh.valid()
                         ? scene_.emission_at(light.mesh, light.triangle, light.barycentric)
                         : lights_.environment_radiance(light.wi);
  }
  if (const Rgb* inside = v.inside_along(light.wi); inside && std::isfinite(light.distance))
    light.radiance *= transmittance(*inside, light.distance);
  const float ratio =
      light.punctual ? 0 : mixture_pdf_w(v, light.wi, eval.pdf_w, eval.base_pdf_w) / light.pdf_w;
  const float mis_over_pdf = 1 / (light.pdf_w * (1 + sqr(ratio)));  // the power heuristic
  float unguided_weight = 1;
  if (learner_.on() && !light.punctual)
    unguided_weight =
        (1 + sqr(ratio)) / (1 + sqr(v.with_caustics(light.wi, eval.pdf_w) / light.pdf_w));
  const Rgb scattered = eval.f_cos * light.radiance * mis_over_pdf;
  if (scattered.is_black()) return true;
  const Rgb arriving = path.throughput * scattered;
  if (!is_finite(arriving)) {
    path.radiance = arriving;
    return false;
  }
  ++counters_.rays;
  AwaitedLight& awaited = shadow_rays_.add(shadow_ray(v, light));
  awaited.light = arriving;
  awaited.pixel = &pixel.radiance;
  awaited.scattered = scattered;
  awaited.vertex = learner_.current();
  awaited.punctual = light.punctual;
  awaited.pick = pick;
  awaited.unguided_weight = unguided_weight;
  if (split_) {
    const LayersOf of = layers_of(path.depth, light.source);
    if (of.bounce >= 0) awaited.layer = pixel.layers + of.bounce;
    if (of.group >= 0) awaited.group = pixel.layers + of.group;
  }
  return true;
}

// The ray starts off the surface, and must end before the light. It is aimed from there: with the
// direction from the surface, a light seen at a grazing angle would be in its own way.
inline Ray PathTracer::shadow_ray(const PathVertex& v, const LightSample& light) {
  Ray ray{v.ray_origin(light.wi), light.wi};
  if (!std::isfinite(light.distance)) return ray;
  const Vec3 to_light = v.surface.p + light.wi * light.distance - ray.o;
  const float distance = length(to_light);
  if (distance > 0) ray.d = to_light / distance;
  ray.t_max = std::max(std::min(distance * (1 - 1e-4f), distance - 2 * v.ray_offset), 0.0f);
  return ray;
}

// Russian roulette.
inline bool PathTracer::survive(PathState& path, const PathVertex& v, float u_roulette) {
  const Survival survival = this->survival(path, v);
  float unguided_chance = 1;
  if (learner_.on()) {
    unguided_chance = this->unguided_chance(
        path.depth, path.throughput * (path.eta_scale * path.guidance * path.survival_chance /
                                       path.unguided_survival_chance));
    path.unguided_survival_chance *= unguided_chance;
  }
  if (survival.chance < 1) {
    const Rgb control = path.throughput * survival.control;
    // It stands for light of the next surface and of those behind it.
    const auto pay = [&](Rgb light) {
      path.radiance += light;
      if (split_ && split_->layers.bounces > 0)
        paid_.push_back({split_->layers.bounce(path.depth + 1), light});
    };
    if (!(u_roulette < survival.chance)) {
      pay(control);
      return false;
    }
    const float survivors = 1 / survival.chance;
    path.survival_chance *= survival.chance;
    pay(control * (1 - survivors));
    path.throughput *= survivors;
  }
  learner_.survived(v.kind != BsdfKind::kDelta, survival.chance, survival.control, unguided_chance);
  return true;
}

// Where the table is credible, by the noise that what follows would bring into the pixel, with the
// table's expectation of what the base sends on as control variate (after Rath et al. 2022, "EARS",
// and Mueller et al. 2020, "Neural Control Variates"); else by throughput from some depth on. Lobes
// have no control variate: their whole second moment counts. Nor has any light that is kept by
// groups, of which the table knows nothing.
inline PathTracer::Survival PathTracer::survival(PathState& path, const PathVertex& v) {
  if (guide_expects_ && guiding_ != Guiding::kOff && v.parts.base_chance > 0) {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    const GuideExpectation expected = guide_->expectation(v.at);
    if (expected.credible) {
      const Rgb control = v.parts.base_albedo * expected.arriving;
      if (learner_.on()) learner_.expected(control);
      if (guiding_ == Guiding::kOn) {
        if (!settings_.russian_roulette) return {};
        const float arriving = luminance(expected.arriving);
        const float of_base =
            luminance(path.throughput * v.parts.base_albedo) *
            (has_groups() ? std::hypot(arriving, expected.deviation) : expected.deviation);
        const float of_lobes = v.parts.lobes_albedo.is_black()
                                   ? 0.0f
                                   : luminance(path.throughput * v.parts.lobes_albedo) *
                                         std::hypot(arriving, expected.deviation);
        const float noise = of_base + of_lobes;
        if (path.pixel_deviation == 0) {
          path.pixel_deviation = noise;
          path.deviation_guessed = true;
        }
        if (!(path.pixel_deviation > 0)) return {};
        const float chance = kRouletteFactor * noise / path.pixel_deviation;
        // A guess may be far off: without a control variate black pixels stay black.
        return {std::clamp(chance, kLeastSurvival, 1.0f),
                path.deviation_guessed || has_groups() ? Rgb{} : control};
      }
    }
  }
  // A path that was guided to light has little throughput, and so has one in glass: that is no
  // reason to end it.
  return {unguided_chance(path.depth,
                          path.throughput * (path.eta_scale * std::max(1.0f, path.guidance))),
          {}};
}

inline float PathTracer::unguided_chance(int depth, Rgb throughput) const {
  if (!settings_.russian_roulette || depth < kRouletteFromDepth) return 1;
  return std::min(0.95f, max_component(throughput));
}

// The next direction.
inline bool PathTracer::go_on(PathState& path, const PathVertex& v, const Hit& hit, float u_lobe,
                              Vec2 u_direction) {
  ScatterSample next;
  if (!scatter(v, u_lobe, u_direction, next)) return false;
  const bool straight =
      next.delta && scene_.meshes[hit.mesh.value].pane && v.is_straight(path.ray.d, next.wi);
  if (straight) next.weight *= pane_correction(v, path.ray.d, hit);
  const bool absorbed = next.weight.is_black();
  if (!next.delta) {
    learner_.scattered(next);
  } else if (!absorbed) {
    learner_.scattered_delta(v.kind != BsdfKind::kDelta, next.weight);
  }
  if (absorbed) return false;
  path.throughput *= next.weight;
  if (straight) {
    go_straight(path, v, hit);
    return true;
  }
  path.reach = 0;
  if (textured_ && !next.delta)
    path.spread += std::min(kSpreadOfScattering / std::sqrt(next.pdf_w), kWidestSpread);
  path.inside = v.inside_along(next.wi);
  path.eta_scale *= v.material.eta_scale(v.surface.ng, v.wo(), next.wi);
  path.ray = {v.ray_origin(next.wi), next.wi};
  path.pdf_w = next.pdf_w;
  path.delta = next.delta;
  path.from = v.receiver;
  path.from_lights = v.lights.weights;
  if (!next.delta && next.bsdf_pdf_w > 0) path.guidance *= next.pdf_w / next.bsdf_pdf_w;
  ++path.depth;
  return true;
}

// As a ray to a light might have: for nee nothing was there.
inline void PathTracer::go_straight(PathState& path, const PathVertex& v, const Hit& hit) {
  path.ray.o = v.ray_origin(path.ray.d);
  path.reach += hit.t;
}

// A pane after the last surface that the path may meet: behind it may be the light that nee's ray
// from that surface finds.
bool PathTracer::leave_by_pane(PathState& path, const PathVertex& v, const Hit& hit, float u_lobe,
                               Vec2 u_direction) {
  const std::optional<BsdfSample> s = v.bsdf.sample(v.bsdf_at, u_lobe, u_direction);
  if (!s || !s->delta || !v.is_straight(path.ray.d, v.frame.to_world(s->wi))) return false;
  const Rgb weight = s->weight * pane_correction(v, path.ray.d, hit);
  learner_.scattered_delta(false, weight);
  path.throughput *= weight;
  go_straight(path, v, hit);
  return true;
}

// What passes a pane for rays to lights, over what passes by the shading normal and by textures as
// wide as the path sees them.
Rgb PathTracer::pane_correction(const PathVertex& v, Vec3 d, const Hit& hit) const {
  const Rgb drawn = v.bsdf.straight(v.bsdf_at);
  Rgb ratio = scene_.straight(d, hit.ng, hit);
  for (int i = 0; i < 3; ++i) ratio[i] = drawn[i] > 0 ? ratio[i] / drawn[i] : 0;
  return ratio;
}

}  // namespace qray
