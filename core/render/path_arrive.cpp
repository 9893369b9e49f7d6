// Where paths arrive: the environment or a surface, what it emits, and what it is made of.
#include <bit>
#include <cmath>
#include <new>

#include "core/base/cycle_clock.h"
#include "core/render/path.h"
#include "core/render/path_weights.h"

namespace qray {

// The light that a path meets where it leaves the scene, weighted against nee having drawn this
// direction.
void PathTracer::add_environment(int lane) {
  if (!lights_.has_environment() || hides_lights_to(lane)) return;
  const auto [emitted, nee_pdf_w] =
      lights_.from_environment(path_.d[lane], path_.from_lights[index(lane)]);
  const bool delta = path_.delta >> lane & 1;
  const float mis = delta || !settings_.nee ? 1.0f : power_heuristic(path_.pdf_w[lane], nee_pdf_w);
  const Rgb light = path_.throughput[lane] * emitted * mis;
  path_.radiance.set(lane, path_.radiance[lane] + light);
  const int depth = path_.depth[index(lane)];
  if (depth == 1 && path_.pixel[index(lane)].seen) *path_.pixel[index(lane)].seen += light;
  if (split_) pay_by_layer(lane, depth - 1, lights_.environment_source(), light);
  learner(lane).emitted(emitted, mis);
}

void PathTracer::absorb(int lane, float distance) {
  const Rgb kept = transmittance(*path_.inside[index(lane)], distance);
  path_.throughput.set(lane, path_.throughput[lane] * kept);
  learner(lane).attenuated(kept);
}

// Light that the surface emits, weighted against nee having drawn this point.
void PathTracer::add_emission(int lane, const MeshShading& mesh, const SurfacePoint& surface) {
  const float cos_light = vertex_.cos_geometric[lane];
  if (hides_lights_to(lane)) return;
  if (!(cos_light > 0 || mesh.material->emission_two_sided)) return;
  const Rgb emitted = mesh.emission_textured()
                          ? scene_.textures->color(mesh.material->emission, surface.uv)
                          : mesh.material->emission.value;
  float mis = 1;
  if (!(path_.delta >> lane & 1) && settings_.nee) {
    Hit met = vertex_.hit[lane];
    met.t += path_.reach[lane];
    mis = power_heuristic(path_.pdf_w[lane], lights_.pdf_w_of_hit(path_.from(lane), met, cos_light,
                                                                  path_.from_lights[index(lane)]));
  }
  const Rgb light = path_.throughput[lane] * emitted * mis;
  path_.radiance.set(lane, path_.radiance[lane] + light);
  const int depth = path_.depth[index(lane)];
  if (depth == 1 && path_.pixel[index(lane)].seen) *path_.pixel[index(lane)].seen += light;
  if (split_) pay_by_layer(lane, depth - 1, vertex_.hit.mesh[index(lane)], light);
  learner(lane).emitted(emitted, mis);
}

// Of a blend, the part that is drawn.
const MaterialShading& PathTracer::material_at(int lane, Vec3 wo, SurfacePoint& surface) const {
  const MeshShading& mesh = scene_.meshes[vertex_.hit.mesh[index(lane)]];
  if (!mesh.blends) return mesh;
  const MaterialShading& part = scene_.resolve(mesh, surface.uv, vertex_.u.d.y[lane]);
  if (part.bends) scene_.bend(part, vertex_.hit[lane], wo, surface);
  return part;
}

bool PathTracer::is_lambert(int lane, const MaterialShading& material) const {
  return material.kind == BsdfKind::kDiffuse && !material.anisotropic && !material.seen_whole &&
         material.opaque && !path_.inside[index(lane)];
}

uint32_t PathTracer::arrive(uint32_t lanes) {
  if (lanes == 0) return 0;
  VertexLanes& v = vertex_;
  const WideVec3 d = path_.d.wide(), wo = -d;
  const WideVec3 ng = normalize(v.hit.ng.wide());
  const Wide t = v.hit.t.wide();
  WideVec3 p = path_.o.wide() + d * t;
  v.p = p;
  v.ng = ng;
  v.ns = ng;
  v.cos_geometric = dot(wo, ng);
  if (textured_) path_.width = path_.width.wide() + path_.spread.wide() * t;
  v.lambert = v.guided = 0;
  uint32_t exact = 0;  // whose normals are settled
  uint32_t open = 0;   // that light crosses
  for_each_lane(lanes, [&](int lane) {
    const size_t i = index(lane);
    const uint32_t bit = 1u << lane;
    const MeshShading& mesh = scene_.meshes[v.hit.mesh[i]];
    if (mesh.plain && !path_.inside[i] && !caustics_) {
      if (at_most(lane)) {
        lanes &= ~bit;
        return;
      }
      v.material[i] = &mesh;
      v.lights[i] = {};
      v.lambert |= bit;
      v.reflectance.set(lane, mesh.constant.reflectance);
      return;
    }
    SurfacePoint& surface = v.surface[i];
    surface.p = v.p[lane];
    surface.ng = surface.ns = v.ng[lane];
    surface.color.reset();
    const Vec3 wo_one = -path_.d[lane];
    if (mesh.interpolated || mesh.sphere || mesh.needs_uv()) {
      surface.uv = {};
      scene_.complete(mesh, v.hit[lane], wo_one, path_.width[lane], surface);
      if (mesh.sphere) {
        v.p.set(lane, surface.p);
        v.ng.set(lane, surface.ng);
        v.cos_geometric[lane] = dot(wo_one, surface.ng);
      }
    }
    if (path_.inside[i]) absorb(lane, v.hit.t[lane]);
    if (mesh.emits) add_emission(lane, mesh, surface);
    if (at_most(lane) && !mesh.pane) {
      lanes &= ~bit;
      return;
    }
    const MaterialShading& material = material_at(lane, wo_one, surface);
    if (material.one_sided && v.cos_geometric[lane] < 0) {
      lanes &= ~bit;
      return;
    }
    v.material[i] = &material;
    v.lights[i] = {};
    if (material.seen_whole) {
      exact |= bit;
      surface.ns = PreparedScene::scattering_normal(material, wo_one, surface);
    }
    if (!material.opaque) open |= bit;
    v.ns.set(lane, surface.ns);
    if (is_lambert(lane, material)) {
      v.lambert |= bit;
      v.reflectance.set(lane, scene_.shading_point(material, surface, v.room[i]).reflectance);
    }
  });
  if (lanes == 0) return 0;
  // The sides of the shading normals where the paths come from, or else the triangle's.
  const WideVec3 true_ng = v.ng.wide(), ns = v.ns.wide();
  p = v.p.wide();
  const WideInt usable = (dot(wo, ns) * dot(wo, true_ng) > 0) | mask_of(exact);
  const WideFrame frame(select(usable, ns, true_ng));
  const Wide largest = max(max(max(abs(p.x), abs(p.y)), abs(p.z)), t);
  v.ray_offset = max(largest * kRayOffset, wide(scene_.ray_epsilon));
  const WideVec3 wo_local = frame.to_local(wo);
  v.receiver_n = select(mask_of(open), WideVec3{}, frame.z * copysign(wide(1), wo_local.z));
  v.x = frame.x;
  v.y = frame.y;
  v.z = frame.z;
  v.wo_local = wo_local;
  return lanes;
}

// Of surfaces that are not Lambert's alone, and of those from which paths may aim at caustics.
void PathTracer::make_vertices(uint32_t lanes) {
  find_in_guide(lanes & path_.with_guide);
  if (caustics_) {
    for_each_lane(lanes & vertex_.lambert, [this](int lane) {
      if (caustics_->find(vertex_.p[lane]).share > 0) vertex_.lambert &= ~(1u << lane);
    });
  }
  for_each_lane(lanes & ~vertex_.lambert, [this](int lane) {
    make_vertex(lane);
    if (!at_most(lane)) ask_guide(lane);
  });
  for_each_lane(lanes & vertex_.lambert & path_.with_guide,
                [this](int lane) { ask_guide_at_lambert(lane); });
}

// Where paths will ask it: memory brings what is known there while surfaces are made.
void PathTracer::find_in_guide(uint32_t lanes) {
  uint32_t asking = 0;
  for_each_lane(lanes, [&](int lane) {
    if (path_.guiding[index(lane)] != Guiding::kOff && !vertex_.is_delta(lane) && !at_most(lane))
      asking |= 1u << lane;
  });
  if (asking == 0) return;
  counters_.lookups += static_cast<uint64_t>(std::popcount(asking));
  const CycleScope scope(timed_, counters_.timed_guiding);
  const WideVec3 ng = vertex_.ng.wide();
  Vec3Lanes facing;
  facing = select(vertex_.cos_geometric.wide() > 0, ng, -ng);
  guide_->find_each(vertex_.p, facing, asking, vertex_.in_guide);
}

void PathTracer::make_vertex(int lane) {
  VertexLanes& v = vertex_;
  const size_t i = index(lane);
  const MaterialShading& material = *v.material[i];
  const SurfacePoint& surface = v.surface[i];
  const Hit hit = v.hit[lane];
  const Vec3 wo = -path_.d[lane];
  Frame frame = v.frame(lane);
  Vec3 wo_local = v.wo_local[lane];
  if (material.anisotropic) {
    frame = scene_.turned_frame(material, hit, frame.z, surface.uv);
    wo_local = frame.to_local(wo);
  }
  ShadingPoint& room = v.room[i];
  const ShadingPoint* sp = &scene_.shading_point(material, surface, room);
  if (material.coat_bends) {
    room = *sp;
    room.coat_normal = frame.to_local(scene_.coat_normal(material, hit, wo, surface));
    sp = &room;
  }
  new (&v.vertex[i])
      PathVertex{.surface = surface,
                 .frame = frame,
                 .bsdf = *material.bsdf,
                 .kind = material.kind,
                 .bsdf_at = material.kind == BsdfKind::kDiffuse ? BsdfPoint(*sp, wo_local)
                                                                : material.bsdf->at(*sp, wo_local),
                 .ray_offset = v.ray_offset[lane],
                 .material = material,
                 .inside = path_.inside[i],
                 .at = v.in_guide[i]};
}

void PathTracer::ask_guide(int lane) {
  PathVertex& v = vertex_.at(lane);
  if (v.kind == BsdfKind::kDelta) return;
  const Guiding guiding = path_.guiding[index(lane)];
  const bool asks = guiding != Guiding::kOff;
  if (caustics_ || (asks && (guide_expects_ || v.kind == BsdfKind::kDiffuse))) v.find_parts();
  if (caustics_ && catches_photons(v.bsdf_at, v.parts.base_chance))
    v.caustics = caustics_->find(v.surface.p);
  if (!asks) return;
  const CycleScope scope(timed_, counters_.timed_guiding);
  if (guiding == Guiding::kOn) v.mixture = guide_->mixture(v.at, v.guided_surface());
  const PathLearner& learner = this->learner(lane);
  if (!learner.on()) return;
  v.learns_bsdf = learner.wants_bsdf();
  tell_learner(lane, v.guided_surface(),
               v.learns_bsdf ? v.parts.base_albedo + v.parts.lobes_albedo : v.albedo());
}

void PathTracer::ask_guide_at_lambert(int lane) {
  VertexLanes& v = vertex_;
  const Guiding guiding = path_.guiding[index(lane)];
  if (guiding == Guiding::kOff) return;
  const CycleScope scope(timed_, counters_.timed_guiding);
  if (guiding == Guiding::kOn) {
    const GuideMixture mixture = guide_->mixture(v.in_guide[index(lane)], GuidedSurface{});
    if (mixture.guide > 0) v.guided |= 1u << lane;
    v.guide_chance[lane] = mixture.guide;
    v.cosine_chance[lane] = mixture.base;
  }
  if (learner(lane).on()) tell_learner(lane, GuidedSurface{}, v.reflectance[lane]);
}

void PathTracer::tell_learner(int lane, const GuidedSurface& surface, Rgb albedo) {
  PathLearner& learner = this->learner(lane);
  learner.vertex(vertex_.in_guide[index(lane)], vertex_.p[lane], path_.survival_chance[lane],
                 path_.throughput[lane]);
  if (learner.wants_albedo()) learner.albedo(luminance(albedo));
  if (learner.wants_bsdf()) learner.surface(surface, luminance(albedo));
}

}  // namespace qray
