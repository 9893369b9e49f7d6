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
    return param.texture.valid() ? param.value * rgb(param.texture, uv) : param.value;
  }
  float number(const FloatParam& param, TexturePoint uv) const;
  Rgb rgb(TextureId id, TexturePoint uv) const { return cache_.lookup(handle(id), of(id, uv)); }
  bool empty() const { return handles_.empty(); }
  size_t size_bytes() const { return cache_.size_bytes(); }
  Vec2 texel(TextureId id) const { return cache_.texel(handle(id)); }  // its size in uv

  ShadingPoint point(const Material& material, TexturePoint uv) const;
  // Of the material itself, [0, 1], the cutoff applied; not of a blend's parts.
  float opacity(const Material& material, TexturePoint uv) const;

 private:
  struct Handle {
    int of_cache;
    bool second_uvs;
  };
  int handle(TextureId id) const { return handles_[id.value].of_cache; }
  // Where the texture is looked up: in the set of uvs that it asks for.
  TexturePoint of(TextureId id, TexturePoint at) const {
    return handles_[id.value].second_uvs ? TexturePoint(at.second_uv, at.second_width) : at;
  }

  TextureCache cache_;
  std::vector<Handle> handles_;  // by TextureId
};

}  // namespace qray
