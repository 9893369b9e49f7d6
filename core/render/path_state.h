// Values of one path: the random numbers of a vertex, where its light goes, and a direction chosen.
#pragma once

#include "core/math/sampler.h"
#include "core/math/vec.h"

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

// Where a pixel's samples go, which must live until the tracer's flush().
struct PixelTarget {
  Rgb* radiance = nullptr;  // their sum
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
