// glTF's materials as ours, docs/gltf.md. Throws ImportFailure. One import.
#pragma once

#include "core/import/gltf_texture.h"

namespace qray {

class GltfMaterials {
 public:
  explicit GltfMaterials(GltfImport& import) : import_(import), textures_(import) {}

  struct Converted {
    MaterialId id;
    std::vector<int> uv_sets;  // the TEXCOORDs that its textures ask for: none, one or two
    bool opaque = true;
    bool unlit = false;  // shows its colour, and is no light
  };
  // A material of the file, or, below 0, the one that primitives without have.
  const Converted& convert(int index);

 private:
  Converted convert_new(int index);
  void read_metallic_roughness(const JsonNode& node, Material& m);
  void read_specular_glossiness(const JsonNode& node, Material& m);
  void read_layers(const JsonNode& node, Material& m);
  void read_clearcoat(const JsonNode& node, Material& m);
  void read_iridescence(const JsonNode& node, Material& m);
  void read_transmission(const JsonNode& node, Material& m);
  void read_emission(const JsonNode& node, Material& m);
  void read_alpha(const JsonNode& node, Material& m);
  void read_normal_map(const JsonNode& node, Material& m);
  void make_unlit(Material& m);

  float share(const JsonNode& node, std::string_view key, float fallback);
  Rgb color(const JsonNode& node, std::string_view key, Rgb fallback, float most);
  TextureId texture(const JsonNode& node, std::string_view key, bool srgb);
  float normal_map(const JsonNode& node, std::string_view key, TextureId& map);

  GltfImport& import_;
  GltfTextures textures_;
  std::map<int, Converted> known_;
  std::vector<int> uv_sets_;  // of the material being read
};

}  // namespace qray
