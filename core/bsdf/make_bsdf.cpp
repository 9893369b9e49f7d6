#include "core/base/check.h"
#include "core/bsdf/kinds.h"

namespace qray {

ShadingPoint constant_point(const Material& m) {
  ShadingPoint sp;
  sp.reflectance = m.reflectance.value;
  sp.roughness = m.roughness.value;
  sp.anisotropy = m.anisotropy.value;
  sp.specular = m.specular.value;
  sp.transmittance = m.transmittance.value;
  sp.sheen = m.sheen.value;
  sp.sheen_roughness = m.sheen_roughness.value;
  sp.metallic = m.metallic.value;
  sp.transmission = m.transmission.value;
  sp.clearcoat = m.clearcoat.value;
  sp.clearcoat_roughness = m.clearcoat_roughness.value;
  sp.specular_weight = m.specular_weight.value;
  sp.diffuse_transmission = m.diffuse_transmission.value;
  sp.diffuse_transmission_color = m.diffuse_transmission_color.value;
  sp.iridescence = m.iridescence.value;
  sp.film_nm = m.film_nm.value;
  return sp;
}

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
      return make_thin_dielectric(material);
    case MaterialKind::kPrincipled:
      return make_principled(material);
    case MaterialKind::kBlend:
      return nullptr;
  }
  QRAY_CHECK(!"a kind of material without a Bsdf");
  return nullptr;
}

}  // namespace qray
