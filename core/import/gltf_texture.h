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

  // Which TEXCOORD the textureInfo `key` of `node` asks for; none: there is no texture.
  std::optional<int> uv_set(const JsonNode& node, std::string_view key);
  // None: there is no texture, or one that is not read. `second_uvs`: the set is its mesh's second.
  TextureId find(const JsonNode& node, std::string_view key, bool srgb, bool second_uvs);
  // Its alpha channel a as a picture of 1 - scale a. None, with a warning, where that would be too
  // many texels in all: unlike other pictures these are made at once.
  TextureId complement_of_alpha(const JsonNode& info, TextureId id, float scale);

 private:
  std::optional<int> find_source(int texture);
  TextureId add(Texture texture);

  GltfImport& import_;
  // By texture, encoding, set of uvs and uv transform.
  std::map<std::tuple<int, bool, bool, std::array<float, 6>>, TextureId> known_;
  std::map<std::pair<TextureId, float>, TextureId> complements_;
  int64_t texels_made_ = 0;
};

}  // namespace qray
