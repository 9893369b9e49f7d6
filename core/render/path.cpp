#include "core/render/path.h"

#include "core/base/cycle_clock.h"

namespace qray {
namespace {

constexpr uint64_t kTimedEvery = 64;

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
      guiding_(guide ? Guiding::kOn : Guiding::kOff),
      learners_(kWidth, PathLearner(guide)),
      light_learner_(guide, lights),
      split_(split),
      caustics_(caustics) {}

void PathTracer::sample(const Ray& ray, const Sampler& sampler, GuideDelta* learn,
                        float pixel_deviation, PixelTarget pixel) {
  ++counters_.paths;
  if (guiding_ == Guiding::kOn) ++counters_.guided_paths;
  if (lights_.empty()) return;  // black, whatever the path
  while (path_.in_flight == kAllLanes) advance();
  const int lane = std::countr_one(path_.in_flight);
  path_.start(lane, ray, pixel_, sampler, pixel_deviation, pixel, guiding_);
  learner(lane).begin(learn, guide_expects_ ? pixel.saved : nullptr);  // others are not judged
  if (learn || guiding_ != Guiding::kOff) path_.with_guide |= 1u << lane;
}

void PathLanes::start(int lane, const Ray& ray, const PixelCone& cone, const Sampler& sampler,
                      float deviation, const PixelTarget& target, Guiding how) {
  const auto i = static_cast<size_t>(lane);
  const uint32_t bit = 1u << lane;
  in_flight |= bit;
  with_guide &= ~bit;
  pixel[i] = target;
  guiding[i] = how;
  samplers.set(lane, sampler);
  o.set(lane, ray.o);
  d.set(lane, ray.d);
  spread[lane] = cone.angle;
  width[lane] = cone.width;
  depth[i] = 1;
  radiance.set(lane, {});
  throughput.set(lane, Rgb{1.0f});
  inside[i] = nullptr;
  eta_scale[lane] = 1;
  pdf_w[lane] = 0;
  delta |= bit;
  reach[lane] = 0;
  from_p.set(lane, {});
  from_n.set(lane, {});
  from_lights[i] = nullptr;
  guidance[lane] = 1;
  pixel_deviation[lane] = deviation;
  deviation_guessed &= ~bit;
  survival_chance[lane] = 1;
  unguided_survival_chance[lane] = 1;
}

void PathTracer::advance() {
  timed_ = steps_++ % kTimedEvery == 0;
  const CycleScope scope(timed_, counters_.timed_total);

  // The next surfaces, or the way out, and light that they emit.
  uint32_t lanes = intersect(path_.in_flight);
  const auto for_each_interpolated = [&](auto ask) {
    for_each_lane(lanes, [&](int lane) {
      const MeshShading& mesh = scene_.meshes[vertex_.hit.mesh[index(lane)]];
      if (mesh.interpolated) ask(*mesh.mesh, vertex_.hit.triangle[index(lane)]);
    });
  };
  for_each_interpolated([](const Mesh& mesh, uint32_t i) { prefetch_triangle(mesh, i); });
  path_.samplers.next_pairs(vertex_.u);
  for_each_interpolated([](const Mesh& mesh, uint32_t i) { prefetch_vertices(mesh, i); });
  for_each_lane(path_.in_flight & ~lanes, [this](int lane) { add_environment(lane); });
  lanes = arrive(lanes);
  uint32_t last = 0, leaving = 0;
  for_each_lane(lanes, [&](int lane) {
    if (at_most(lane)) last |= 1u << lane;
  });
  lanes &= ~last;
  // Lights come first: while surfaces are made, memory brings what is read of the environment.
  const uint32_t lit = choose_lights(lanes);
  make_vertices(lanes | last);
  // A pane after the last surface that a path may meet: behind it may be the light that nee's ray
  // from that surface finds.
  for_each_lane(last, [&](int lane) {
    if (leave_by_pane(lane)) leaving |= 1u << lane;
  });
  lanes = add_direct_light(lanes, lit);
  lanes = survive(lanes);
  lanes = scatter(lanes);
  go_on(lanes);
  for_each_lane(vertex_.straight | leaving, [this](int lane) { go_straight(lane); });

  lanes |= vertex_.straight | leaving;
  for_each_lane(path_.in_flight & ~lanes, [this](int lane) { finish(lane); });
  path_.in_flight = lanes;
  if (shadow_rays_.enough()) trace_shadow_rays();
}

uint32_t PathTracer::intersect(uint32_t lanes) {
  counters_.rays += static_cast<uint64_t>(std::popcount(lanes));
  for_each_lane(lanes, [this](int lane) {
    counters_.guided_rays += path_.guiding[index(lane)] == Guiding::kOn;
  });
  const CycleScope scope(timed_, counters_.timed_tracing);
  return scene_.accel->intersect(path_.o, path_.d, lanes, vertex_.hit);
}

void PathTracer::finish(int lane) {
  const PixelTarget& pixel = path_.pixel[index(lane)];
  learner(lane).end();
  const Rgb radiance = path_.radiance[lane];
  if (is_finite(radiance)) {
    if (!radiance.is_black()) {
      AwaitedLight& light = shadow_rays_.add_without_ray();
      light.light = radiance;
      light.pixel = pixel.radiance;
    }
    for (const Paid& paid : paid_[index(lane)]) {
      AwaitedLight& light = shadow_rays_.add_without_ray();
      light.light = paid.light;
      light.layer = pixel.layers + paid.layer;
    }
  } else {
    ++counters_.dropped_samples;
  }
  paid_[index(lane)].clear();
}

void PathTracer::trace_shadow_rays() {
  const uint64_t start = cycle_count();
  shadow_rays_.trace(*scene_.accel);
  const uint64_t traced = cycle_count();
  shadow_rays_.for_each_free([this](const AwaitedLight& awaited, Rgb passed) {
    const Rgb light = awaited.light * passed, scattered = awaited.scattered * passed;
    if (awaited.pixel) *awaited.pixel += light;
    if (awaited.layer) *awaited.layer += light;
    if (awaited.group) *awaited.group += light;
    if (awaited.vertex != PathLearner::kNoVertex)
      learner(awaited.lane)
          .direct(awaited.vertex, scattered, awaited.punctual, awaited.unguided_weight);
    light_learner_.sends(awaited.pick, luminance(scattered));
  });
  shadow_rays_.clear();
  for (PathLearner& learner : learners_) learner.flush();
  light_learner_.flush();
  // As steps are timed: one in many.
  const uint64_t learned = cycle_count();
  counters_.timed_tracing += (traced - start) / kTimedEvery;
  counters_.timed_guiding += (learned - traced) / kTimedEvery;
  counters_.timed_total += (learned - start) / kTimedEvery;
}

void PathTracer::flush() {
  while (path_.in_flight) advance();
  trace_shadow_rays();
}

void PathTracer::discard() {
  path_.in_flight = 0;
  shadow_rays_.clear();
  for (PathLearner& learner : learners_) learner.discard();
  for (std::vector<Paid>& paid : paid_) paid.clear();
  light_learner_.discard();
}

PathTracer::LayersOf PathTracer::layers_of(int scattered, uint32_t source) const {
  LayersOf of;
  if (split_->layers.bounces > 0 && scattered > 0) of.bounce = split_->layers.bounce(scattered);
  if (split_->layers.groups > 0) of.group = split_->layers.group(split_->group_of_source[source]);
  return of;
}

// Once the path has ended as a number.
void PathTracer::pay_by_layer(int lane, int scattered, uint32_t source, Rgb light) {
  const LayersOf of = layers_of(scattered, source);
  if (of.bounce >= 0) paid_[index(lane)].push_back({of.bounce, light});
  if (of.group >= 0) paid_[index(lane)].push_back({of.group, light});
}

}  // namespace qray
