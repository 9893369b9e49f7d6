// What a guide answers where a path scatters: the point's name in the table, the directions that
// are sampled there, and what arrives. Frames and directions are in world space, densities per
// steradian.
#pragma once

#include "core/base/ids.h"
#include "core/math/frame.h"
#include "core/math/vec.h"

namespace qray {

// The directions that a guide samples at a point: its densities integrate to 1 over them, and are 0
// elsewhere.
enum class GuideDomain : uint8_t {
  kHemisphere,  // about the frame's z
  kSphere,      // every direction: what has no normal, or a table that does not ask for it
};

// One lookup, shared by sample, pdf_w and record.
struct GuidePoint {
  StateId state;           // invalid: nothing is known here yet
  uint64_t key = 0;        // the state's name in the table, known or not
  Frame frame{{0, 0, 1}};  // z: a hemisphere's axis
  GuideDomain domain = GuideDomain::kHemisphere;

  bool covers(Vec3 wi) const { return domain == GuideDomain::kSphere || dot(frame.z, wi) > 0; }
};

// How a surface scatters by itself, as far as it rules how a guide and its BSDF are mixed. As it
// stands: Lambert's.
struct GuidedSurface {
  float base_chance = 1;  // BsdfParts::base_chance
  bool smooth = false;    // its lobes are mirrors or clear glass
};

// A density p = guide p_guide + base p_base + lobes p_lobes, where p_base and p_lobes are the parts
// of the BSDF's own density.
struct GuideMixture {
  float guide = 0;  // the chance to draw from the guide
  float base = 1, lobes = 1;

  // Guide and whole BSDF.
  static GuideMixture of(float guide) { return {guide, 1 - guide, 1 - guide}; }
  // The guide in place of the base, and of this share of the lobes.
  static GuideMixture in_place_of_base(float base_chance, float share_of_lobes) {
    return {lerp(share_of_lobes, base_chance, 1.0f), 0, 1 - share_of_lobes};
  }

  // p of a direction, of the densities that its parts have there.
  float pdf_w(float of_guide, float of_base, float of_lobes) const {
    return guide * of_guide + base * of_base + lobes * of_lobes;
  }
};

struct GuideSample {
  Vec3 wi;          // unit, away from the surface
  float pdf_w = 0;  // what pdf_w(point, wi) gives
};

// What a table expects where it knows enough. Nothing rests on it being right.
struct GuideExpectation {
  bool credible = false;
  // Mean over the projected hemisphere of the radiance that arrives, the light's share that nee
  // counts left out: a diffuse surface sends reflectance x arriving.
  Rgb arriving;
  float deviation = 0;  // standard, of the luminance of one sample of `arriving`
};

}  // namespace qray
