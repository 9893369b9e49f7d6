#include "core/render/material_textures.h"

namespace qray {

Status MaterialTextures::open(const std::vector<Texture>& textures, int threads) {
  for (const Texture& texture : textures) {
    Result<int> handle = cache_.open(texture);
    if (!handle.ok()) return handle.error();
    handles_.push_back({handle.value(), texture.second_uvs});
  }
  cache_.read(threads);
  return {};
}

float MaterialTextures::number(const FloatParam& param, TexturePoint uv) const {
  if (!param.texture.valid()) return param.value;
  if (param.channel == 3)
    return param.value * cache_.lookup_alpha(handle(param.texture), of(param.texture, uv));
  const Rgb value = rgb(param.texture, uv);
  return param.value * (param.channel == kLuminance ? luminance(value) : value[param.channel]);
}

ShadingPoint MaterialTextures::point(const Material& m, TexturePoint uv) const {
  ShadingPoint sp;
  sp.reflectance = color(m.reflectance, uv);
  sp.roughness = number(m.roughness, uv);
  sp.anisotropy = number(m.anisotropy, uv);
  sp.specular = color(m.specular, uv);
  sp.transmittance = color(m.transmittance, uv);
  sp.sheen = color(m.sheen, uv);
  sp.sheen_roughness = number(m.sheen_roughness, uv);
  sp.metallic = number(m.metallic, uv);
  sp.transmission = number(m.transmission, uv);
  sp.clearcoat = number(m.clearcoat, uv);
  sp.clearcoat_roughness = number(m.clearcoat_roughness, uv);
  sp.specular_weight = number(m.specular_weight, uv);
  sp.diffuse_transmission = number(m.diffuse_transmission, uv);
  sp.diffuse_transmission_color = color(m.diffuse_transmission_color, uv);
  sp.iridescence = number(m.iridescence, uv);
  sp.film_nm = m.film_nm.value;
  if (m.film_nm.texture.valid()) {
    const float share = rgb(m.film_nm.texture, uv)[m.film_nm.channel];
    sp.film_nm = lerp(share, m.film_least_nm, m.film_nm.value);
  }
  return sp;
}

float MaterialTextures::opacity(const Material& material, TexturePoint uv) const {
  const float opacity = number(material.opacity, uv);
  if (material.alpha_cutoff > 0) return opacity >= material.alpha_cutoff ? 1.0f : 0.0f;
  return std::clamp(opacity, 0.0f, 1.0f);
}

}  // namespace qray
