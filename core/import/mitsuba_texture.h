// Mitsuba's textures as ours, and plugin parameters that may be one. Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_color.h"

namespace qray {

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
  // GGX alpha as our roughness, its root.
  FloatParam find_roughness(const MitsubaNode& plugin, float fallback);
  // pre: node.tag == "texture".
  ColorParam read(const MitsubaNode& node);
  // The same picture, not decoded: normals are numbers, whatever the file says.
  TextureId as_numbers(TextureId id);

 private:
  ColorParam read_bitmap(const MitsubaNode& node);
  ColorParam read_checkerboard(const MitsubaNode& node);
  ColorParam read_scale(const MitsubaNode& node);
  TextureId add(Texture texture);
  TextureId add_in_memory(const MitsubaNode& node, const Image& image, const Texture& like);
  float read_alpha_value(const MitsubaNode& plugin, const MitsubaNode& parameter);

  MitsubaImport& import_;
  std::map<const MitsubaNode*, ColorParam> known_;
  int depth_ = 0;
};

}  // namespace qray
