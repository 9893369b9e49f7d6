#include "core/render/caustic_photons.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math/frame.h"
#include "core/math/sampler.h"
#include "core/render/path_state.h"

namespace qray {
namespace {

constexpr uint64_t kPhotonSeed = 0x63617573;
constexpr int kMostBounces = 12;
constexpr size_t kBatch = 1024;
// Of photons sent anywhere: if hardly any of the first goes by a mirror, no more are sent.
constexpr size_t kTrial = 16 * kBatch, kFewestFound = 4;
constexpr size_t kMostSent = 256 * kBatch, kEnoughFound = kBatch;
constexpr size_t kWantedPhotons = 96 * kBatch, kMostArrivals = 16 * kBatch;

enum class Fate { kLost, kDirect, kCaustic };

struct Traced {
  Fate fate = Fate::kLost;
  CausticPhoton photon{};
};

bool scatters_by_mirror_or_glass(const MaterialShading& material) {
  return !material.blends && material.kind != BsdfKind::kDiffuse;
}

Traced trace_photon(const PreparedScene& scene, const PhotonStart& start, Sampler& sampler) {
  std::optional<Ray> sent = scene.lights.emit(start.u_light, start.u_side, start.u_point,
                                              start.u_direction, scene.bounds);
  if (!sent) return {};
  Ray ray = *sent;
  bool turned = false;  // else light sampling finds this way, through panes as well
  for (int mirrors = 0; mirrors <= kMostBounces; ++mirrors) {
    const VertexNumbers u = VertexNumbers::draw(sampler);
    Hit hit;
    if (!scene.accel->intersect(ray, hit)) return {};
    SurfacePoint surface = scene.surface_at(ray, hit);
    const Vec3 wo = -ray.d;
    const MaterialShading* material = &scene.meshes[hit.mesh.value];
    if (material->blends) {
      material = &scene.resolve(*material, surface.uv, u.u_blend);
      if (material->bends) scene.bend(*material, hit, wo, surface);
    }
    if (material->one_sided && dot(wo, surface.ng) < 0) return {};
    const Frame frame = scene.scattering_frame(*material, hit, wo, surface);
    ShadingPoint room;
    const BsdfPoint at =
        material->bsdf->at(scene.shading_point(*material, surface, room), frame.to_local(wo));
    if (catches_photons(at, material->bsdf->parts(at).base_chance))
      return {turned ? Fate::kCaustic : Fate::kDirect, {surface.p, ray.o}};
    const std::optional<BsdfSample> next = material->bsdf->sample(at, u.u_lobe, u.u_direction);
    if (!next || !(u.u_roulette < max_component(next->weight))) return {};
    const Vec3 wi = frame.to_world(next->wi);
    if (!(dot(wi, surface.ng) * next->wi.z > 0)) return {};
    turned |= !(next->delta && scene.meshes[hit.mesh.value].pane &&
                dot(wi, surface.ng) * dot(wo, surface.ng) < 0);
    const float offset = scene.ray_offset(surface.p, hit.t);
    ray = {surface.p + surface.ng * std::copysign(offset, dot(surface.ng, wi)), wi};
  }
  return {};
}

// Near `at` on the unit circle, mostly very near (Kelemen et al. 2002, "A Simple and Robust
// Mutation Strategy for the Metropolis Light Transport Algorithm").
float near_number(float at, float u) {
  const float step = std::exp2(-12 + 7 * std::abs(2 * u - 1));
  const float to = u < 0.5f ? at - step : at + step;
  return std::min(to - std::floor(to), kOneMinusEpsilon);
}

PhotonStart near_start(const PhotonStart& at, const Sampler::Pairs& u) {
  return {at.u_light,
          at.u_side,
          {near_number(at.u_point.x, u.a.x), near_number(at.u_point.y, u.a.y)},
          {near_number(at.u_direction.x, u.b.x), near_number(at.u_direction.y, u.b.y)}};
}

// start_of(i, Sampler&): of photon i of the batch; the sampler's further numbers are the photon's.
template <class StartOf>
void trace_batch(const PreparedScene& scene, TaskPool& pool, std::vector<PhotonStart>& starts,
                 std::vector<Traced>& traced, const StartOf& start_of) {
  constexpr size_t kChunk = 64;
  pool.run((starts.size() + kChunk - 1) / kChunk, [&](size_t chunk, int) {
    Sampler sampler(kPhotonSeed);
    for (size_t i = chunk * kChunk; i < std::min(starts.size(), (chunk + 1) * kChunk); ++i) {
      starts[i] = start_of(i, sampler);
      traced[i] = trace_photon(scene, starts[i], sampler);
    }
  });
}

}  // namespace

CausticPhotons send_photons(const PreparedScene& scene, TaskPool& pool) {
  CausticPhotons out;
  if (!scene.lights.connects() ||
      std::ranges::none_of(scene.materials, scatters_by_mirror_or_glass))
    return out;
  std::vector<PhotonStart> starts(kBatch);
  std::vector<Traced> traced(kBatch);
  size_t sent = 0, sent_for_arrivals = 0;
  while (sent < kMostSent && out.photons.size() < kEnoughFound &&
         (sent < kTrial || out.photons.size() >= kFewestFound)) {
    trace_batch(scene, pool, starts, traced, [&](size_t i, Sampler& sampler) {
      sampler.start(0, 0, static_cast<uint32_t>(sent + i));
      const Sampler::Pairs u = sampler.next_pairs();
      return PhotonStart{u.c.x, u.c.y, u.a, u.b};
    });
    sent += kBatch;
    const bool counts = out.arrivals.size() < kMostArrivals;
    for (size_t i = 0; i < kBatch; ++i) {
      if (counts && traced[i].fate != Fate::kLost) out.arrivals.push_back(traced[i].photon.p);
      if (traced[i].fate != Fate::kCaustic) continue;
      out.photons.push_back(traced[i].photon);
      out.starts.push_back(starts[i]);
    }
    if (counts) sent_for_arrivals = sent;
  }
  if (out.photons.size() < kFewestFound) return {};
  out.share = static_cast<double>(out.photons.size()) / static_cast<double>(sent);
  out.arrival_share = 1 / static_cast<double>(sent_for_arrivals);
  return out;
}

// Each is the start of a Markov chain whose states are all equally likely (Hachisuka and Jensen
// 2011, "Robust Adaptive Photon Tracing Using Photon Path Visibility").
void send_nearby(CausticPhotons& photons, const PreparedScene& scene, TaskPool& pool) {
  std::vector<PhotonStart> starts(photons.starts.size());
  std::vector<Traced> traced(starts.size());
  size_t tried = 0;
  for (uint32_t round = 1; photons.photons.size() < kWantedPhotons && tried < 2 * kWantedPhotons;
       ++round) {
    trace_batch(scene, pool, starts, traced, [&](size_t i, Sampler& sampler) {
      sampler.start(static_cast<uint32_t>(i), round, 0);
      return near_start(photons.starts[i], sampler.next_pairs());
    });
    tried += starts.size();
    for (size_t i = 0; i < starts.size(); ++i) {
      if (traced[i].fate != Fate::kCaustic) continue;
      photons.photons.push_back(traced[i].photon);
      photons.starts[i] = starts[i];
    }
  }
}

}  // namespace qray
