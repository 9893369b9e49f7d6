// The next directions of paths, and the way there.
#include <cmath>

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
  if (vertex_.plain & lanes) scatter_plain();
  uint32_t left = lanes;
  for_each_lane(lanes & ~vertex_.plain, [&](int lane) {
    if (!scatter_one(lane)) left &= ~(1u << lane);
  });
  left &= ~lanes_of(is_black(vertex_.weight.wide()));
  vertex_.straight &= left;
  return left & ~vertex_.straight;
}

// Lambert surfaces, by cosine. Both normals must agree on the side; a black weight ends the path.
void PathTracer::scatter_plain() {
  VertexLanes& v = vertex_;
  WideVec3 local = square_to_cosine_hemisphere(v.u.b.x.wide(), v.u.b.y.wide());
  const Wide pdf_w = max(Wide{}, local.z) * kInvPi, wo_z = v.wo_local.z.wide();
  local.z = copysign(local.z, wo_z);
  const WideVec3 wi = v.x.wide() * local.x + v.y.wide() * local.y + v.z.wide() * local.z;
  const WideInt scatters = (wo_z != 0) & (pdf_w != 0) & (dot(wi, v.ng.wide()) * local.z > 0);
  const WideRgb reflectance = v.reflectance.wide();
  v.wi = wi;
  v.pdf_w = pdf_w;
  v.weight = WideRgb{scatters ? reflectance.r : Wide{}, scatters ? reflectance.g : Wide{},
                     scatters ? reflectance.b : Wide{}};
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
