// The next directions of paths, and the way there.
#include <cmath>

#include "core/base/cycle_clock.h"
#include "core/render/path.h"

namespace qray {
namespace {

// A scattered ray stands for a cone of its share of the sphere; textures are averaged over a tenth
// of that across.
constexpr float kSpreadOfScattering = 0.1f, kWidestSpread = 0.3f;  // radians

}  // namespace

uint32_t PathTracer::scatter(uint32_t lanes) {
  vertex_.delta = vertex_.straight = 0;
  if (lanes == 0) return 0;
  if (vertex_.lambert & lanes) scatter_lambert(lanes & vertex_.lambert);
  uint32_t left = lanes;
  for_each_lane(lanes & ~vertex_.lambert, [&](int lane) {
    if (!scatter_one(lane)) left &= ~(1u << lane);
  });
  left &= ~lanes_of(is_black(vertex_.weight.wide()));
  vertex_.straight &= left;
  return left & ~vertex_.straight;
}

// By cosine, or by the guide. Both normals must agree on the side; a black weight ends the path.
void PathTracer::scatter_lambert(uint32_t lanes) {
  VertexLanes& v = vertex_;
  const WideVec3 ng = v.ng.wide();
  const WideRgb reflectance = v.reflectance.wide();
  const Wide wo_z = v.wo_local.z.wide();
  WideVec3 local = square_to_cosine_hemisphere(v.u.b.x.wide(), v.u.b.y.wide());
  const Wide cosine_pdf_w = max(Wide{}, local.z) * kInvPi;
  local.z = copysign(local.z, wo_z);
  const WideVec3 wi = v.x.wide() * local.x + v.y.wide() * local.y + v.z.wide() * local.z;
  const WideInt drawn = (wo_z != 0) & (cosine_pdf_w != 0);
  const WideInt scatters = drawn & (dot(wi, ng) * local.z > 0);
  v.drawn = lanes_of(drawn);
  v.wi = wi;
  v.pdf_w = cosine_pdf_w;
  v.bsdf_pdf_w = cosine_pdf_w;
  v.weight = WideRgb{scatters ? reflectance.r : Wide{}, scatters ? reflectance.g : Wide{},
                     scatters ? reflectance.b : Wide{}};
  v.guide_pdf_w = Wide{};
  if (const uint32_t guided = v.guided & lanes) scatter_lambert_by_guide(guided);
  if (path_.with_guide & lanes) tell_learner_of_lambert(lanes & path_.with_guide);
}

// In place of what scatter_lambert() has: by the mixture of guide and cosine.
void PathTracer::scatter_lambert_by_guide(uint32_t lanes) {
  VertexLanes& v = vertex_;
  const uint32_t drawing = lanes & lanes_of(v.u.c.y.wide() < v.guide_chance.wide());
  Vec3Lanes guide_wi;
  FloatLanes drawn_pdf_w, other_pdf_w;
  {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    if (drawing) guide_->sample_each(v.in_guide, v.u.b, drawing, guide_wi, drawn_pdf_w);
    if (const uint32_t others = lanes & ~drawing & v.drawn)
      guide_->pdf_w_each(v.in_guide, v.wi, others, other_pdf_w);
  }
  v.drawn |= drawing;
  const WideInt mask = mask_of(lanes), by_guide = mask_of(drawing);
  const WideVec3 wi = select(by_guide, guide_wi.wide(), v.wi.wide());
  const Wide wi_z = dot(wi, v.z.wide());
  const Wide eval_pdf_w = v.wo_local.z.wide() * wi_z > 0 ? abs(wi_z) * kInvPi : Wide{};
  const Wide bsdf_pdf_w = by_guide ? eval_pdf_w : v.pdf_w.wide();
  const Wide guide_pdf_w = by_guide ? drawn_pdf_w.wide() : other_pdf_w.wide();
  const Wide pdf_w = v.guide_chance.wide() * guide_pdf_w + v.cosine_chance.wide() * bsdf_pdf_w;
  const WideRgb cosine_weight = v.weight.wide(), f_cos = v.reflectance.wide() * bsdf_pdf_w;
  const WideInt scatters = by_guide ? dot(wi, v.ng.wide()) * wi_z > 0 : ~is_black(cosine_weight);
  const Wide inverse = 1 / pdf_w, rescaled = bsdf_pdf_w / pdf_w;
  const auto weight = [&](const Wide& before, const Wide& f) {
    const Wide after = by_guide ? f * inverse : before * rescaled;
    return mask ? scatters & (f != 0) ? after : Wide{} : before;
  };
  const WideRgb weights{weight(cosine_weight.r, f_cos.r), weight(cosine_weight.g, f_cos.g),
                        weight(cosine_weight.b, f_cos.b)};
  v.wi = wi;
  v.weight = weights;
  v.pdf_w = mask ? pdf_w : v.pdf_w.wide();
  v.bsdf_pdf_w = mask ? bsdf_pdf_w : v.bsdf_pdf_w.wide();
  v.guide_pdf_w = mask ? guide_pdf_w : Wide{};
  const WideInt goes_on = mask & ~is_black(weights) & (bsdf_pdf_w > 0);
  path_.guidance = path_.guidance.wide() * (goes_on ? pdf_w / bsdf_pdf_w : wide(1));
}

void PathTracer::tell_learner_of_lambert(uint32_t lanes) {
  const VertexLanes& v = vertex_;
  for_each_lane(lanes & v.drawn, [&](int lane) {
    PathLearner& learner = this->learner(lane);
    if (!learner.on()) return;
    const float bsdf_pdf_w = v.bsdf_pdf_w[lane];
    learner.scattered({.wi = v.wi[lane],
                       .weight = v.weight[lane],
                       .pdf_w = v.pdf_w[lane],
                       .bsdf_pdf_w = bsdf_pdf_w,
                       .unguided_pdf_w = bsdf_pdf_w,
                       .base_pdf_w = bsdf_pdf_w,
                       .guide_pdf_w = v.guide_pdf_w[lane]});
  });
}

bool PathTracer::scatter_one(int lane) {
  const PathVertex& v = vertex_.at(lane);
  ScatterSample next;
  if (!scatter(v, vertex_.u.c.y[lane], vertex_.u.b[lane], next)) return false;
  const bool straight = next.delta && scene_.meshes[vertex_.hit.mesh[index(lane)]].pane &&
                        v.is_straight(path_.d[lane], next.wi);
  if (straight) next.weight *= pane_correction(lane, v);
  const uint32_t bit = 1u << lane;
  if (!next.delta) {
    learner(lane).scattered(next);
  } else if (!next.weight.is_black()) {
    learner(lane).scattered_delta(v.kind != BsdfKind::kDelta, next.weight);
  }
  vertex_.wi.set(lane, next.wi);
  vertex_.weight.set(lane, next.weight);
  vertex_.pdf_w[lane] = next.pdf_w;
  if (next.delta) vertex_.delta |= bit;
  if (straight) vertex_.straight |= bit;
  if (straight || next.weight.is_black()) return true;
  path_.inside[index(lane)] = v.inside_along(next.wi);
  path_.eta_scale[lane] *= v.material.eta_scale(v.surface.ng, v.wo(), next.wi);
  if (!next.delta && next.bsdf_pdf_w > 0) path_.guidance[lane] *= next.pdf_w / next.bsdf_pdf_w;
  return true;
}

void PathTracer::go_on(uint32_t lanes) {
  for_each_lane(vertex_.straight, [this](int lane) {
    path_.throughput.set(lane, path_.throughput[lane] * vertex_.weight[lane]);
  });
  if (lanes == 0) return;
  const VertexLanes& v = vertex_;
  const WideInt mask = mask_of(lanes);
  const WideVec3 wi = v.wi.wide(), ng = v.ng.wide(), p = v.p.wide();
  const WideVec3 start = p + ng * copysign(v.ray_offset.wide(), dot(ng, wi));
  const Wide pdf_w = v.pdf_w.wide();
  const WideRgb before = path_.throughput.wide(), after = before * v.weight.wide();
  path_.throughput =
      WideRgb{mask ? after.r : before.r, mask ? after.g : before.g, mask ? after.b : before.b};
  if (textured_) {
    const Wide spread = path_.spread.wide();
    const Wide wider = spread + min(kSpreadOfScattering / sqrt(pdf_w), wide(kWidestSpread));
    path_.spread = mask & ~mask_of(v.delta) ? wider : spread;
  }
  path_.reach = mask ? Wide{} : path_.reach.wide();
  path_.o = select(mask, start, path_.o.wide());
  path_.d = select(mask, wi, path_.d.wide());
  path_.pdf_w = mask ? pdf_w : path_.pdf_w.wide();
  path_.delta = (path_.delta & ~lanes) | (v.delta & lanes);
  path_.from_p = select(mask, p, path_.from_p.wide());
  path_.from_n = select(mask, v.receiver_n.wide(), path_.from_n.wide());
  for_each_lane(lanes, [&](int lane) {
    path_.from_lights[index(lane)] = v.lights[index(lane)].weights;
    ++path_.depth[index(lane)];
  });
}

// As a ray to a light might have: for nee nothing was there.
void PathTracer::go_straight(int lane) {
  path_.o.set(lane, vertex_.at(lane).ray_origin(path_.d[lane]));
  path_.reach[lane] += vertex_.hit.t[lane];
}

bool PathTracer::leave_by_pane(int lane) {
  const PathVertex& v = vertex_.at(lane);
  const std::optional<BsdfSample> s =
      v.bsdf.sample(v.bsdf_at, vertex_.u.c.y[lane], vertex_.u.b[lane]);
  if (!s || !s->delta || !v.is_straight(path_.d[lane], v.frame.to_world(s->wi))) return false;
  const Rgb weight = s->weight * pane_correction(lane, v);
  learner(lane).scattered_delta(false, weight);
  path_.throughput.set(lane, path_.throughput[lane] * weight);
  return true;
}

// What passes a pane for rays to lights, over what passes by the shading normal and by textures as
// wide as the path sees them.
Rgb PathTracer::pane_correction(int lane, const PathVertex& v) const {
  const Rgb drawn = v.bsdf.straight(v.bsdf_at);
  const Hit hit = vertex_.hit[lane];
  Rgb ratio = scene_.straight(path_.d[lane], hit.ng, hit);
  for (int i = 0; i < 3; ++i) ratio[i] = drawn[i] > 0 ? ratio[i] / drawn[i] : 0;
  return ratio;
}

}  // namespace qray
