// The images that materials read, and a material's parameters at a point of one. Lookups: any
// thread, once open.
#pragma once

#include <vector>

#include "core/bsdf/bsdf.h"
#include "core/image/texture_cache.h"
#include "core/scene/scene.h"

namespace qray {

class MaterialTextures {
 public:
  Status open(const std::vector<Texture>& textures, int threads);

  Rgb color(const ColorParam& param, TexturePoint uv) const {
    return param.texture.valid() ? param.value * cache_.lookup(handle(param.texture), uv)
                                 : param.value;
  }
  float number(const FloatParam& param, TexturePoint uv) const;
  Rgb rgb(TextureId id, TexturePoint uv) const { return cache_.lookup(handle(id), uv); }
  bool empty() const { return handles_.empty(); }
  size_t size_bytes() const { return cache_.size_bytes(); }
  Vec2 texel(TextureId id) const { return cache_.texel(handle(id)); }  // its size in uv

  ShadingPoint point(const Material& material, TexturePoint uv) const;
  // Of the material itself, [0, 1], the cutoff applied; not of a blend's parts.
  float opacity(const Material& material, TexturePoint uv) const;

 private:
  int handle(TextureId id) const { return handles_[id.value]; }

  TextureCache cache_;
  std::vector<int> handles_;  // by TextureId
};

}  // namespace qray
