// Lambert: f = reflectance / pi.
#include "core/bsdf/kinds.h"
#include "core/math/warp.h"

namespace qray {
namespace {

class Diffuse final : public Bsdf {
 public:
  BsdfKind kind() const override { return BsdfKind::kDiffuse; }

  BsdfEval eval(const ShadingPoint& sp, Vec3 wo, Vec3 wi) const override {
    if (!(wo.z * wi.z > 0)) return {};
    const float pdf_w = cosine_hemisphere_pdf_w(std::abs(wi.z));
    return {sp.reflectance * pdf_w, pdf_w};
  }

  std::optional<BsdfSample> sample(const ShadingPoint& sp, Vec3 wo, float,
                                   Vec2 u_dir) const override {
    Vec3 wi = square_to_cosine_hemisphere(u_dir);
    const float pdf_w = cosine_hemisphere_pdf_w(wi.z);
    if (wo.z == 0 || pdf_w == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BsdfSample{wi, sp.reflectance, pdf_w, false};
  }

  Rgb albedo(const ShadingPoint& sp, Vec3) const override { return sp.reflectance; }
};

}  // namespace

std::unique_ptr<Bsdf> make_diffuse() {
  return std::make_unique<Diffuse>();
}

}  // namespace qray
