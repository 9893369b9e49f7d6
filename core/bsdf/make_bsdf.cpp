#include "core/base/check.h"
#include "core/bsdf/kinds.h"

namespace qray {

std::unique_ptr<Bsdf> make_bsdf(const Material& material) {
  switch (material.kind) {
    case MaterialKind::kDiffuse:
      return make_diffuse();
    case MaterialKind::kConductor:
      return make_conductor(material);
    case MaterialKind::kDielectric:
      return make_dielectric(material);
    case MaterialKind::kPlastic:
      return make_plastic(material);
    case MaterialKind::kThinDielectric:
    case MaterialKind::kPrincipled:
    case MaterialKind::kBlend:
      break;
  }
  QRAY_CHECK(!"a kind of material without a Bsdf");
  return nullptr;
}

}  // namespace qray
