// What a path carries from step to step: its random numbers, its state and the direction chosen.
// Values of one path, one thread.
#pragma once

#include "core/math/ray.h"
#include "core/math/sampler.h"
#include "core/math/vec.h"
#include "core/render/light_tree.h"

namespace qray {

// The random numbers of one vertex of a path, by what they decide.
struct VertexNumbers {
  float u_blend;       // the part of a blended material
  float u_light;       // the light to connect to
  Vec2 u_light_point;  // the point on it
  float u_roulette;    // whether the path survives
  float u_lobe;        // guide or BSDF, and the BSDF's lobe
  Vec2 u_direction;

  static VertexNumbers draw(Sampler& sampler) {
    const Sampler::Pairs pairs = sampler.next_pairs();
    return {.u_blend = pairs.d.y,
            .u_light = pairs.c.x,
            .u_light_point = pairs.a,
            .u_roulette = pairs.d.x,
            .u_lobe = pairs.c.y,
            .u_direction = pairs.b};
  }
};

// A path so far.
struct PathState {
  Ray ray;                      // to what comes next
  float spread;                 // metres of width that the ray gains each metre
  float width = 0;              // metres that the ray stands for, across it
  int depth = 1;                // the surface that comes next, from 1 on
  Rgb radiance{};               // that the pixel is paid
  Rgb throughput{1.0f};         // of what arrives along the ray
  const Rgb* inside = nullptr;  // absorption along the ray, per metre; null: none
  // Radiance is that much more where the ray is than in the open, as the square of the index is;
  // throughput is as much less, which says nothing of what the path may bring.
  float eta_scale = 1;
  // The ray's direction: its density, and whether nee could not have made it. It cannot make the
  // camera's.
  float pdf_w = 0;
  bool delta = true;
  float reach = 0;       // metres that it then went straight through panes, as nee's rays do
  LightReceiver from{};  // the surface where it was chosen,
  const float* from_lights = nullptr;  // and what is known of lights there (LightPick::sample())
  float guidance = 1;  // the densities of its directions over what the BSDFs' own were, multiplied
  // Of a sample of the pixel. Not known (0), it is guessed to be what the first place with
  // expectations may bring.
  float pixel_deviation = 0;
  bool deviation_guessed = false;
  float survival_chance = 1;           // that it got so far
  float unguided_survival_chance = 1;  // that it would have without a guide's expectations
};

// Where a pixel's samples go, which must live until the tracer's flush().
struct PixelTarget {
  Rgb& radiance;  // their sum
  // The sum of what guiding saved each of them, of the second moment of its luminance; null: not
  // wanted (guide_savings.h).
  double* saved = nullptr;
  // The sum of what of their radiance lights and the environment showed of themselves to the
  // camera; null: not wanted.
  Rgb* seen = nullptr;
  Rgb* layers = nullptr;  // its layers' sums (FilmLayers), side by side; null: none are kept
};

// A direction that a path takes on.
struct ScatterSample {
  Vec3 wi;                   // world, unit
  Rgb weight;                // f |cos| / pdf_w; black: the surface absorbs the path
  float pdf_w = 0;           // of the whole mixture, per steradian
  float bsdf_pdf_w = 0;      // of the BSDF alone
  float unguided_pdf_w = 0;  // without a guide; differs from the BSDF's where paths aim at caustics
  float base_pdf_w = 0;      // its base's part of that
  float guide_pdf_w = 0;     // of the guide; 0 where it was not asked
  Rgb lobes_weight{};        // what of the weight is not of the BSDF's base
  bool delta = false;        // by a mirror or clear glass: the densities mean nothing
};

}  // namespace qray
