// Mitsuba's textures as ours, and plugin parameters that may be one. Throws ImportFailure.
#pragma once

#include <utility>

#include "core/import/mitsuba_color.h"

namespace qray {

// Microfacets of one alpha in the direction in which u grows and one in which v does, up to 1.
void set_roughness(Material& out, float alpha_u, float alpha_v);

class MitsubaTextures {
 public:
  explicit MitsubaTextures(MitsubaImport& import) : import_(import) {}

  // A parameter that is a colour or a texture. Reflectances are brought down to 1.
  ColorParam find_color(const MitsubaNode& plugin, std::string_view name, Rgb fallback,
                        ColorUse use = ColorUse::kReflectance);
  // A parameter that is a number or a texture's first channel.
  FloatParam find_share(const MitsubaNode& plugin, std::string_view name, float fallback);
  // A mask: a picture's alpha where it has one.
  FloatParam find_opacity(const MitsubaNode& plugin);
  // Alpha as our roughness, its root; with two of them, anisotropy too.
  void find_roughness(const MitsubaNode& plugin, Material& out);
  // pre: node.tag == "texture".
  ColorParam read(const MitsubaNode& node);
  // The same picture, not decoded: normals are numbers, whatever the file says.
  TextureId as_numbers(TextureId id);
  // Whether a texture since the last call was the colours of vertices.
  bool take_vertex_colors() { return std::exchange(vertex_colors_, false); }

 private:
  ColorParam read_bitmap(const MitsubaNode& node);
  ColorParam read_checkerboard(const MitsubaNode& node);
  ColorParam read_scale(const MitsubaNode& node);
  TextureId add(Texture texture);
  TextureId add_in_memory(const MitsubaNode& node, const Image& image, const Texture& like);
  FloatParam find_isotropic(const MitsubaNode& plugin);
  float read_alpha_value(const MitsubaNode& parameter);

  MitsubaImport& import_;
  std::map<const MitsubaNode*, ColorParam> known_;
  bool vertex_colors_ = false;
  int depth_ = 0;
};

}  // namespace qray
