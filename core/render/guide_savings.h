// What guiding saved a pixel at a vertex of a guided path: by how much the second moment of a
// sample's luminance would have been greater if the BSDF alone had drawn the direction, and
// roulette had known no guide. Mean over paths; both sides come from the same paths, so that where
// the guide finds light that the BSDF would miss for long, both are known at once.
//
// Let the direction, drawn with density p, bring the pixel a = w (E m + L): E is what it meets
// shining, m its weight against next event estimation (nee), L all other light, as far as the
// guide's expectations go. Let nee bring d, let the path have survived roulette with chance q,
// against the control variate c. Without the guide the density is p_b, the weights are m_b and, for
// nee, d_b, and the chance is q_b. Then the vertex saves
//   of its direction:  a_b^2 (p / p_b) / q_b - a^2 - (a - c)^2 (1 / q - 1),  a_b = w (E m_b + L)
//   of nee:            d_b^2 - d^2, and with the direction 2 (d_b a_b - d a)
// without the 1 / q that w and d have of the vertices before. Left out: that paths would reach the
// vertex by other weights. Counting them makes the sum exact, and of no use: where guiding pays,
// the product of ratios has the noise that guiding saves.
#pragma once

#include <algorithm>

#include "core/math/vec.h"

namespace qray {

struct GuideSavings {
  float reached = 1;                // the chance to have survived until here
  Rgb throughput;                   // until here
  float nee = 0, unguided_nee = 0;  // d, d_b
  float chance = 1;                 // q
  float unguided_chance = 1;        // q_b
  float control = 0;                // c
  float density_ratio = 0;        // p / p_b; 0: no direction was drawn, or the BSDF never draws it
  Rgb to_pixel;                   // w
  Rgb emitted, unguided_emitted;  // E m, E m_b

  // m_b, of m: the power heuristic.
  float unguided_weight(float mis) const {
    return mis < 1 ? 1 / (1 + sqr(density_ratio) * (1 / mis - 1)) : 1;
  }

  // `rest`: L.
  float saved(Rgb rest) const {
    constexpr float kMostRatio = 64;
    float sum = sqr(unguided_nee) - sqr(nee);
    if (density_ratio > 0) {
      const float a = luminance(to_pixel * (emitted + rest)),
                  unguided = luminance(to_pixel * (unguided_emitted + rest));
      sum +=
          chance * (sqr(unguided) * std::min(density_ratio, kMostRatio) / unguided_chance - sqr(a) -
                    sqr(a - control) * (1 / chance - 1) + 2 * (unguided_nee * unguided - nee * a));
    }
    return sum * reached;
  }
};

}  // namespace qray
