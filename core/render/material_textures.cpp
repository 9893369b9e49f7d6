#include "core/render/material_textures.h"

namespace qray {

Status MaterialTextures::open(const std::vector<Texture>& textures, int threads) {
  for (const Texture& texture : textures) {
    Result<int> handle = cache_.open(texture);
    if (!handle.ok()) return handle.error();
    handles_.push_back(handle.value());
  }
  cache_.read(threads);
  return {};
}

float MaterialTextures::number(const FloatParam& param, TexturePoint uv) const {
  if (!param.texture.valid()) return param.value;
  const int at = handle(param.texture);
  if (param.channel == 3) return param.value * cache_.lookup_alpha(at, uv);
  const Rgb value = cache_.lookup(at, uv);
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
  return sp;
}

float MaterialTextures::opacity(const Material& material, TexturePoint uv) const {
  const float opacity = number(material.opacity, uv);
  if (material.alpha_cutoff > 0) return opacity >= material.alpha_cutoff ? 1.0f : 0.0f;
  return std::clamp(opacity, 0.0f, 1.0f);
}

}  // namespace qray
