// Scattering at a surface. Directions: unit, local (the shading normal is +z; x is the direction in
// which an anisotropic surface is roughest), away from the surface; wo to the eye. Opaque kinds and
// thin ones are alike from both sides; solid dielectrics tell inside (z < 0) from outside.
// Immutable; any thread.
#pragma once

#include <memory>
#include <optional>

#include "core/bsdf/bsdf_point.h"
#include "core/math/vec.h"
#include "core/scene/material.h"

namespace qray {

ShadingPoint constant_point(const Material& material);  // where no texture changes it

// A BSDF is a Lambert base, which scatters into all directions alike but for what layers above it
// keep, and lobes, which are the rest. Either may be missing.
struct BsdfParts {
  float base_chance = 0;  // that sample() draws from the base, by cosine: u_lobe >= 1 - base_chance
  Rgb base_albedo{}, lobes_albedo{};  // about
};

struct BsdfEval {
  Rgb f_cos;        // f * |cos(wi)|; per steradian
  float pdf_w = 0;  // density of sample(), per steradian; 0 for delta lobes
  // What of both is the base's.
  Rgb base_f_cos{};
  float base_pdf_w = 0;
};

struct BsdfSample {
  Vec3 wi;
  Rgb weight;          // f * |cos(wi)| / pdf; for a delta lobe, its share over its chance
  float pdf_w = 0;     // per steradian; unused (0) when delta
  bool delta = false;  // a mirror or smooth refraction: no density
  // What of weight and density is the base's.
  Rgb base_weight{};
  float base_pdf_w = 0;

  // pre: e.pdf_w > 0.
  static BsdfSample of(Vec3 wi, const BsdfEval& e) {
    return {wi, e.f_cos / e.pdf_w, e.pdf_w, false, e.base_f_cos / e.pdf_w, e.base_pdf_w};
  }
};

// What sort of lobes a surface has; rules who may guide it.
enum class BsdfKind : uint8_t {
  kDiffuse,  // Lambert alone
  kGlossy,   // has a density everywhere, not Lambert alone
  kDelta,    // delta lobes alone
  kMixed,    // a delta lobe beside lobes with a density (smooth plastic)
};

// Asked about points that its own at() made.
class Bsdf {
 public:
  virtual ~Bsdf() = default;
  virtual BsdfKind kind() const = 0;
  // `sp` outlives the point.
  BsdfPoint at(const ShadingPoint& sp, Vec3 wo) const {
    BsdfPoint point(sp, wo);
    prepare(point);
    return point;
  }
  BsdfPoint at(ShadingPoint&&, Vec3) const = delete;
  // Both zero where only delta lobes scatter. Reciprocal but for refraction (radiance scaling).
  virtual BsdfEval eval(const BsdfPoint& at, Vec3 wi) const = 0;
  // nullopt: absorbed. Directions with a density follow eval().pdf_w
  // (tests/stat/bsdf_chi2_test.cpp).
  virtual std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2 u_dir) const = 0;
  virtual BsdfParts parts(const BsdfPoint& at) const = 0;
  // Share of the light from straight behind the surface that goes on to wo as if nothing were
  // there: a delta lobe's, as of a pane. Black for solids, which bend it.
  virtual Rgb straight(const BsdfPoint&) const { return {}; }
  // Share of the light from wo's direction that scatters, about; for feature pictures.
  Rgb albedo(const BsdfPoint& at) const {
    const BsdfParts both = parts(at);
    return both.base_albedo + both.lobes_albedo;
  }

 private:
  // Keeps in the point what the calls above would each compute.
  virtual void prepare(BsdfPoint&) const {}
};

// Null for a blend, which is resolved to one of its parts at every hit.
std::unique_ptr<Bsdf> make_bsdf(const Material& material);

}  // namespace qray
