// glTF's textures as ours: samplers, KHR_texture_transform, pictures in files, data URIs and buffer
// views, which are not decoded here. Throws ImportFailure. One import.
#pragma once

#include <map>
#include <tuple>

#include "core/import/gltf_import.h"

namespace qray {

class GltfTextures {
 public:
  explicit GltfTextures(GltfImport& import) : import_(import) {}

  struct Found {
    TextureId id;    // none: there is no texture, or one that is not read
    int uv_set = 0;  // which TEXCOORD it asks for
  };
  // The textureInfo `key` of `node`.
  Found find(const JsonNode& node, std::string_view key, bool srgb);
  // Its alpha channel a as a picture of 1 - scale a. None, with a warning, where that would be too
  // many texels in all: unlike other pictures these are made at once.
  TextureId complement_of_alpha(const JsonNode& info, TextureId id, float scale);

 private:
  std::optional<int> find_source(int texture);
  TextureId add(Texture texture);

  GltfImport& import_;
  // By texture, encoding and uv transform.
  std::map<std::tuple<int, bool, std::array<float, 6>>, TextureId> known_;
  std::map<std::pair<TextureId, float>, TextureId> complements_;
  int64_t texels_made_ = 0;
};

}  // namespace qray
