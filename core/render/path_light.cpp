// Light straight from a light, paid if its ray turns out to be free.
#include <cmath>
#include <limits>

#include "core/base/cycle_clock.h"
#include "core/render/path.h"
#include "core/render/path_weights.h"

namespace qray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace

float PathTracer::mixture_pdf_w(const PathVertex& v, Vec3 wi, float bsdf_pdf_w, float base_pdf_w) {
  if (v.mixture.guide == 0) return v.with_caustics(wi, bsdf_pdf_w);
  const CycleScope scope(timed_, counters_.timed_guiding);
  return v.with_caustics(
      wi, v.mixture.pdf_w(guide_->pdf_w(v.at, wi), base_pdf_w, bsdf_pdf_w - base_pdf_w));
}

// Nothing else finds a light without an extent. A path whose light is no number ends: its sample
// will be dropped.
uint32_t PathTracer::add_direct_light(uint32_t lanes, uint32_t lit) {
  if (lit) lit = choose_points(lit);
  if (lit) lit = scatter_light(lit);
  if (lit) lit = weigh_light(lit);
  if (lit == 0) return lanes;
  aim_at_lights();
  uint32_t ended = 0;
  for_each_lane(lit, [&](int lane) {
    const Rgb arriving = light_.arriving[lane];
    if (is_finite(arriving)) return await(lane, arriving);
    path_.radiance.set(lane, arriving);
    ended |= 1u << lane;
  });
  return lanes & ~ended;
}

// A light of each. What comes back are the lanes to which it may send something.
uint32_t PathTracer::choose_lights(uint32_t lanes) {
  if (!connects_) return 0;
  static const LightSample no_sample{};  // copied: g++ clears memory by a slower instruction
  LightLanes& l = light_;
  uint32_t asking = 0, chosen = 0, searching = 0;
  for_each_lane(lanes, [&](int lane) {
    const size_t i = index(lane);
    if (vertex_.is_delta(lane)) return;
    const uint32_t bit = 1u << lane;
    asking |= bit;
    const LightReceiver receiver = vertex_.receiver(lane);
    LightLearner::Place& place = vertex_.lights[i];
    place = light_learner_.place(receiver, learner(lane).on());
    LightSample& s = l.light[i];
    s = no_sample;
    if (lights_.choose(receiver, vertex_.u.c.x[lane], vertex_.u.a[lane], s, place.weights,
                       l.search[i]))
      chosen |= bit;
    if (s.in_tree) searching |= bit;
  });
  if (searching) {
    lights_.tree().run(l.search, searching);
    for_each_lane(searching, [&](int lane) {
      const size_t i = index(lane);
      if (!lights_.finish_search(l.search[i], vertex_.u.a[lane], l.light[i]))
        chosen &= ~(1u << lane);
    });
  }
  for_each_lane(asking, [&](int lane) {
    const size_t i = index(lane);
    l.pick[i] = learner(lane).on() ? light_learner_.picked(vertex_.lights[i], l.light[i])
                                   : LightLearner::kNoPick;
  });

  uint32_t sending = 0;
  l.varies = l.on_triangle = l.in_environment = 0;
  for_each_lane(chosen, [&](int lane) {
    LightSample& s = l.light[index(lane)];
    if (!settings_.nee && !s.punctual) return;
    const uint32_t bit = 1u << lane;
    sending |= bit;
    l.pdf_w[lane] = s.pdf_w;
    l.with_extent[lane] = s.punctual ? 0.0f : 1.0f;
    if (s.on) {
      l.on_triangle |= bit;
      return l.put(lane, *s.on);
    }
    if (s.varies) l.varies |= bit;
    l.distance[lane] = s.distance;
    if (s.drawn.exists()) {
      l.in_environment |= bit;
      return;
    }
    l.wi.set(lane, s.wi);
    l.radiance.set(lane, s.radiance);
  });
  for_each_lane(l.in_environment,
                [&](int lane) { lights_.environment().prefetch_tile(l.light[index(lane)].drawn); });
  return sending;
}

// A point on each of the lights.
uint32_t PathTracer::choose_points(uint32_t lanes) {
  LightLanes& l = light_;
  for_each_lane(l.in_environment, [&](int lane) {
    lights_.environment().prefetch_picture(l.light[index(lane)].drawn);
  });
  if (l.on_triangle) lanes &= ~l.on_triangle | choose_on_triangles(l.on_triangle);
  for_each_lane(l.in_environment, [&](int lane) {
    LightSample& s = l.light[index(lane)];
    if (!lights_.finish_environment(s)) lanes &= ~(1u << lane);
    l.wi.set(lane, s.wi);
    l.radiance.set(lane, s.radiance);
    l.pdf_w[lane] = s.pdf_w;
  });
  return lanes;
}

// LightPick::sample_triangle().
uint32_t PathTracer::choose_on_triangles(uint32_t lanes) {
  LightLanes& l = light_;
  const WideVec2 b = square_to_triangle(vertex_.u.a.x.wide(), vertex_.u.a.y.wide());
  const WideVec3 to_light = l.p0.wide() + l.e1.wide() * b.x + l.e2.wide() * b.y - vertex_.p.wide();
  const Wide distance2 = dot(to_light, to_light), distance = sqrt(distance2);
  const WideVec3 wi = to_light / distance;
  const Wide cos_light = -dot(wi, l.n.wide());
  const Wide pdf_w = l.pdf_w.wide() * distance2 / (abs(cos_light) * l.area.wide());
  const WideInt mask = mask_of(lanes);
  l.wi = select(mask, wi, l.wi.wide());
  l.distance = mask ? distance : l.distance.wide();
  l.pdf_w = mask ? pdf_w : l.pdf_w.wide();
  if (l.varies & lanes) {
    FloatLanes second, third;
    second = b.x;
    third = b.y;
    for_each_lane(l.varies & lanes, [&](int lane) {
      l.light[index(lane)].barycentric = {second[lane], third[lane]};
    });
  }
  const WideInt seen = l.two_sided.wide() > 0 ? cos_light != 0 : cos_light > 0;
  return lanes & lanes_of(seen & (distance2 > 0));
}

// What the surfaces scatter of it. Both normals must agree on the light's side.
uint32_t PathTracer::scatter_light(uint32_t lanes) {
  const VertexLanes& v = vertex_;
  LightLanes& l = light_;
  const WideVec3 wi = l.wi.wide();
  const Wide wi_z = dot(wi, v.z.wide());
  lanes &= lanes_of(dot(wi, v.ng.wide()) * wi_z > 0);
  const Wide cosine_pdf_w = v.wo_local.z.wide() * wi_z > 0 ? abs(wi_z) * kInvPi : Wide{};
  l.f_cos = v.reflectance.wide() * cosine_pdf_w;
  l.bsdf_pdf_w = cosine_pdf_w;
  l.mixture_pdf_w = cosine_pdf_w;
  const uint32_t guided =
      lanes & v.guided & lanes_of(~is_black(l.f_cos.wide()) & (l.with_extent.wide() > 0));
  if (guided) {
    const CycleScope scope(timed_, counters_.timed_guiding);
    FloatLanes guide_pdf_w;
    guide_->pdf_w_each(v.in_guide, l.wi, guided, guide_pdf_w);
    l.mixture_pdf_w = mask_of(guided) ? v.guide_chance.wide() * guide_pdf_w.wide() +
                                            v.cosine_chance.wide() * cosine_pdf_w
                                      : cosine_pdf_w;
  }
  for_each_lane(lanes & ~v.lambert, [&](int lane) {
    const PathVertex& one = vertex_.at(lane);
    const Vec3 to = l.wi[lane];
    const BsdfEval eval = one.eval(one.frame.to_local(to));
    l.f_cos.set(lane, eval.f_cos);
    l.bsdf_pdf_w[lane] = eval.pdf_w;
    l.mixture_pdf_w[lane] = eval.f_cos.is_black() || l.with_extent[lane] == 0
                                ? 0
                                : mixture_pdf_w(one, to, eval.pdf_w, eval.base_pdf_w);
  });
  return lanes & ~lanes_of(is_black(l.f_cos.wide()));
}

// By the power heuristic. Light that varies over its mesh is looked up here, once it counts.
uint32_t PathTracer::weigh_light(uint32_t lanes) {
  LightLanes& l = light_;
  for_each_lane(lanes & l.varies, [&](int lane) {
    const LightSample& s = l.light[index(lane)];
    l.radiance.set(lane, scene_.emission_at(s.mesh, s.triangle, s.barycentric));
  });
  for_each_lane(lanes & ~vertex_.lambert, [&](int lane) {
    const Rgb* inside = vertex_.at(lane).inside_along(l.wi[lane]);
    const float distance = l.distance[lane];
    if (inside && std::isfinite(distance))
      l.radiance.set(lane, l.radiance[lane] * transmittance(*inside, distance));
  });
  const Wide pdf_w = l.pdf_w.wide();
  const Wide ratio = l.with_extent.wide() > 0 ? l.mixture_pdf_w.wide() / pdf_w : Wide{};
  const Wide mis_over_pdf = 1 / (pdf_w * (1 + ratio * ratio));
  const WideRgb scattered = l.f_cos.wide() * l.radiance.wide() * mis_over_pdf;
  l.scattered = scattered;
  l.arriving = path_.throughput.wide() * scattered;
  return lanes & ~lanes_of(is_black(scattered));
}

// Rays start off the surface, and must end before the light. They are aimed from there: with the
// direction from the surface, a light seen at a grazing angle would be in its own way.
void PathTracer::aim_at_lights() {
  LightLanes& l = light_;
  const WideVec3 p = vertex_.p.wide(), ng = vertex_.ng.wide(), wi = l.wi.wide();
  const Wide offset = vertex_.ray_offset.wide(), distance = l.distance.wide();
  const WideVec3 o = p + ng * copysign(offset, dot(wi, ng));
  const WideVec3 to_light = p + wi * distance - o;
  const Wide left = length(to_light);
  const WideInt ends = distance < kInfinity;
  l.ray_o = o;
  l.ray_d = select(ends & (left > 0), to_light / left, wi);
  l.ray_t_max = ends ? max(min(left * (1 - 1e-4f), left - 2 * offset), Wide{}) : wide(kInfinity);
}

void PathTracer::await(int lane, Rgb arriving) {
  const LightLanes& l = light_;
  const size_t i = index(lane);
  const PathLearner& learner = this->learner(lane);
  const PixelTarget& pixel = path_.pixel[i];
  ++counters_.rays;
  counters_.guided_rays += path_.guiding[i] == Guiding::kOn;
  AwaitedLight& awaited = shadow_rays_.add({l.ray_o[lane], l.ray_d[lane], l.ray_t_max[lane]});
  awaited.light = arriving;
  awaited.pixel = pixel.radiance;
  awaited.scattered = l.scattered[lane];
  awaited.lane = lane;
  awaited.vertex = learner.current();
  awaited.punctual = l.with_extent[lane] == 0;
  awaited.pick = l.pick[i];
  if (learner.on() && !awaited.punctual) {
    float unguided_pdf_w = l.bsdf_pdf_w[lane];
    if (!(vertex_.lambert >> lane & 1))
      unguided_pdf_w = vertex_.at(lane).with_caustics(l.wi[lane], unguided_pdf_w);
    awaited.unguided_weight = (1 + sqr(l.mixture_pdf_w[lane] / l.pdf_w[lane])) /
                              (1 + sqr(unguided_pdf_w / l.pdf_w[lane]));
  }
  if (split_) {
    const LayersOf of = layers_of(path_.depth[i], l.light[i].source);
    if (of.bounce >= 0) awaited.layer = pixel.layers + of.bounce;
    if (of.group >= 0) awaited.group = pixel.layers + of.group;
  }
}

}  // namespace qray
