#include "core/render/material_shading.h"

#include "core/bsdf/kinds.h"

namespace qray {

MaterialShading material_shading(const Material& m, const Bsdf* bsdf,
                                 std::span<const MaterialShading> parts) {
  MaterialShading s;
  s.material = &m;
  s.bsdf = bsdf;
  s.constant = constant_point(m);
  s.emits = m.emits();
  for (const TextureId id :
       {m.reflectance.texture, m.roughness.texture, m.anisotropy.texture, m.specular.texture,
        m.transmittance.texture, m.sheen.texture, m.sheen_roughness.texture, m.metallic.texture,
        m.transmission.texture, m.clearcoat.texture, m.clearcoat_roughness.texture,
        m.specular_weight.texture, m.diffuse_transmission.texture,
        m.diffuse_transmission_color.texture, m.iridescence.texture, m.film_nm.texture})
    s.textured = s.textured || id.valid();
  s.anisotropic = m.anisotropic();
  s.bends = m.normal_map.valid() || m.bump_map.texture.valid();
  s.seen_whole = m.kind == MaterialKind::kPrincipled;
  s.coat_bends = m.kind == MaterialKind::kPrincipled && m.clearcoat.value > 0 &&
                 m.own_coat_normal && (s.bends || m.coat_normal_map.valid());
  s.masked = m.opacity.texture.valid() || m.opacity.value < 1;
  if (m.kind == MaterialKind::kBlend) {
    s.blends = true;
    const MaterialShading &first = parts[m.first.value], &second = parts[m.second.value];
    s.masked = s.masked || first.masked || second.masked;
    s.kind = first.kind == second.kind ? first.kind : BsdfKind::kGlossy;
    return s;
  }
  s.kind = bsdf->kind();
  const bool passes = m.kind == MaterialKind::kPrincipled &&
                      (m.transmission.value > 0 || m.diffuse_transmission.value > 0);
  s.bounds_solid = m.kind == MaterialKind::kDielectric || (passes && !m.thin);
  s.opaque = !s.bounds_solid && !passes && m.kind != MaterialKind::kThinDielectric;
  s.one_sided = !m.two_sided && s.opaque;
  s.pane =
      m.kind == MaterialKind::kThinDielectric ||
      (m.kind == MaterialKind::kPrincipled && m.transmission.value > 0 && m.thin && is_smooth(m));
  return s;
}

}  // namespace qray
