// Eight paths side by side, one in each lane: what they carry from surface to surface, and what one
// step of all of them works on. Steps that are the same for every surface are taken for eight at
// once (core/math/wide.h); where paths differ, lane by lane. No lane's bits depend on the others.
// One PathTracer's.
#pragma once

#include <array>
#include <cstddef>
#include <new>
#include <vector>

#include "core/accel/embree_scene.h"
#include "core/math/wide_sampler.h"
#include "core/render/light_learner.h"
#include "core/render/path_learner.h"
#include "core/render/path_state.h"
#include "core/render/path_vertex.h"

namespace qray {

// How a path deals with the guide.
enum class Guiding : uint8_t { kOff, kWatch, kOn };  // kWatch: looks up, so that it can learn

// Paths so far.
struct PathLanes {
  uint32_t in_flight = 0;   // the lanes that have a path
  uint32_t with_guide = 0;  // those whose paths ask the guide, or that it learns from
  std::array<PixelTarget, kWidth> pixel{};
  std::array<Guiding, kWidth> guiding{};
  WideSampler samplers;

  Vec3Lanes o, d;                   // the ray to what comes next; d: unit
  FloatLanes spread;                // metres of width that the ray gains each metre
  FloatLanes width;                 // metres that the ray stands for, across it
  std::array<int, kWidth> depth{};  // the surface that comes next, from 1 on
  RgbLanes radiance;                // that the pixel is paid
  RgbLanes throughput;              // of what arrives along the ray
  // Absorption along the ray, per metre; null: none.
  std::array<const Rgb*, kWidth> inside{};
  // Radiance is that much more where the ray is than in the open, as the square of the index is;
  // throughput is as much less, which says nothing of what the path may bring.
  FloatLanes eta_scale;
  // The ray's direction: its density, and whether nee could not have made it. It cannot make the
  // camera's.
  FloatLanes pdf_w;
  uint32_t delta = 0;  // lanes
  FloatLanes reach;    // metres that it then went straight through panes, as nee's rays do
  // The surface where it was chosen, and what is known of lights there (LightPick::sample()).
  Vec3Lanes from_p, from_n;
  std::array<const float*, kWidth> from_lights{};
  FloatLanes guidance;  // the densities of its directions over the BSDFs' own, multiplied
  // Of a sample of the pixel. Not known (0), it is guessed to be what the first place with
  // expectations may bring.
  FloatLanes pixel_deviation;
  uint32_t deviation_guessed = 0;       // lanes
  FloatLanes survival_chance;           // that it got so far
  FloatLanes unguided_survival_chance;  // that it would have without a guide's expectations

  LightReceiver from(int lane) const { return {from_p[lane], from_n[lane]}; }
  void start(int lane, const Ray& ray, const PixelCone& cone, const Sampler& sampler,
             float deviation, const PixelTarget& target, Guiding how);
};

// A light of each surface that the paths have met, and what it sends there, within one step.
struct LightLanes {
  std::array<LightSample, kWidth> light;
  std::array<LightTree::Search, kWidth> search;
  std::array<uint32_t, kWidth> pick;  // LightLearner::picked()
  Vec3Lanes p0, e1, e2, n;            // EmittingTriangle, where the light is one
  FloatLanes area, two_sided;         // the same; two_sided: 1 or 0
  // Lanes: whose radiance is still to be looked up; where the light is a triangle, the environment.
  uint32_t varies = 0, on_triangle = 0, in_environment = 0;
  Vec3Lanes wi;  // the rest as LightSample has it,
  FloatLanes distance, pdf_w;
  FloatLanes with_extent;  // but 0 for punctual ones, else 1
  RgbLanes radiance;
  RgbLanes f_cos;                // of the surface, for light from there
  FloatLanes mixture_pdf_w;      // with which the surface sends paths there,
  FloatLanes bsdf_pdf_w;         // and its BSDF alone
  RgbLanes scattered, arriving;  // by the path's last vertex; in the pixel
  Vec3Lanes ray_o, ray_d;
  FloatLanes ray_t_max;

  void put(int lane, const EmittingTriangle& t) {
    LightSample& s = light[static_cast<size_t>(lane)];
    p0.set(lane, t.p0);
    e1.set(lane, t.e1);
    e2.set(lane, t.e2);
    n.set(lane, t.n);
    area[lane] = t.area;
    two_sided[lane] = t.two_sided ? 1.0f : 0.0f;
    radiance.set(lane, t.emission);
    s.source = t.mesh.value;
    if (!t.varies) return;
    varies |= 1u << lane;
    s.mesh = t.mesh;
    s.triangle = t.index;
  }
};

// The surfaces that the paths have met, within one step.
struct VertexLanes {
  WideSampler::Pairs u;  // a light's point, a direction, (light, lobe), (roulette, blend)
  HitLanes hit;
  Vec3Lanes p, ng, ns;  // the surface
  Vec3Lanes x, y, z;    // the frame in which it scatters; z: the normal
  Vec3Lanes wo_local;   // to the previous vertex
  FloatLanes cos_geometric, ray_offset;
  // Lambert surfaces alone: all that they have is here.
  uint32_t lambert = 0;
  RgbLanes reflectance;
  uint32_t guided = 0;                     // those where the guide draws directions,
  FloatLanes guide_chance, cosine_chance;  // by GuideMixture's `guide` and `base`
  // Of the others. The room that their vertices refer to is theirs.
  std::array<SurfacePoint, kWidth> surface{};
  std::array<ShadingPoint, kWidth> room{};
  struct alignas(PathVertex) Storage {
    std::byte bytes[sizeof(PathVertex)];
  };
  std::array<Storage, kWidth> vertex;
  GuidePoints in_guide;  // of paths that ask it
  ExpectationLanes expected;

  std::array<const MaterialShading*, kWidth> material{};
  std::array<LightLearner::Place, kWidth> lights{};  // found where lights are connected to
  Vec3Lanes receiver_n;                              // LightReceiver::n

  // The direction that each takes on.
  Vec3Lanes wi;
  RgbLanes weight;
  FloatLanes pdf_w;
  uint32_t delta = 0, straight = 0;
  // The rest of ScatterSample, of Lambert surfaces where one was drawn.
  uint32_t drawn = 0;
  FloatLanes bsdf_pdf_w, guide_pdf_w;

  PathVertex& at(int lane) {
    return *std::launder(reinterpret_cast<PathVertex*>(&vertex[static_cast<size_t>(lane)]));
  }
  Frame frame(int lane) const { return {x[lane], y[lane], z[lane]}; }
  LightReceiver receiver(int lane) const { return {p[lane], receiver_n[lane]}; }
  bool is_delta(int lane) const {
    return material[static_cast<size_t>(lane)]->kind == BsdfKind::kDelta;
  }
};

}  // namespace qray
