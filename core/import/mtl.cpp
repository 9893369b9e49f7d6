#include "core/import/mtl.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <map>

#include "core/image/picture_reader.h"
#include "core/import/scene_folder.h"
#include "core/scene/value_ranges.h"

namespace qray {
namespace {

float clamp_to(float v, float lo, float hi) {
  return std::isfinite(v) ? std::clamp(v, lo, hi) : lo;
}

class Converter {
 public:
  Converter(const std::filesystem::path& folder, ObjContents& out) : folder_(folder), out_(out) {}

  Material convert(const tinyobj::material_t& in) {
    Material m;
    m.name = in.name;
    m.emission.value = color(in, "Ke", in.emission, kMaxRadiance);
    const Rgb diffuse = color(in, "Kd", in.diffuse, 1);
    const Rgb specular = color(in, "Ks", in.specular, 1);
    if (is_glass(in)) {
      m.kind = MaterialKind::kDielectric;
      m.ior = in.ior > 1 ? clamp_to(in.ior, 1, 4) : 1.5f;
      return m;
    }
    if (in.illum == 5 || in.illum == 3) {
      // A mirror of colour Ks: an index of 0 + i reflects all light at every angle.
      m.kind = MaterialKind::kConductor;
      m.eta = Rgb{0.0f};
      m.k = Rgb{1.0f};
      m.specular.value = specular;
      read_surface(in, m);
      return m;
    }
    m.reflectance = {diffuse, texture(in, "map_Kd", in.diffuse_texname, in.diffuse_texopt)};
    if (m.reflectance.texture.valid() && diffuse.is_black()) m.reflectance.value = Rgb{1.0f};
    const TextureId rough = texture(in, "map_Pr", in.roughness_texname, in.roughness_texopt, false);
    const TextureId metal = texture(in, "map_Pm", in.metallic_texname, in.metallic_texopt, false);
    if (in.roughness > 0 || in.metallic > 0 || rough.valid() || metal.valid()) {
      m.kind = MaterialKind::kPrincipled;
      if (in.ior > 1) m.ior = clamp_to(in.ior, 1, 4);
      m.roughness = share(in.roughness, rough);
      m.metallic = share(in.metallic, metal);
    } else if (max_component(specular) > 0) {
      m.kind = MaterialKind::kPlastic;
      if (in.ior > 1) m.ior = clamp_to(in.ior, 1.01f, 4);
      const float f0 = sqr((m.ior - 1) / (m.ior + 1));
      for (int i = 0; i < 3; ++i) m.specular.value[i] = std::min(1.0f, specular[i] / f0);
      // Phong's exponent as the GGX alpha of like width; roughness is its root.
      const float alpha = std::sqrt(2 / (2 + clamp_to(in.shininess, 0, 1e6f)));
      m.roughness.value = std::sqrt(alpha);
      m.specular.texture = texture(in, "map_Ks", in.specular_texname, in.specular_texopt);
    }
    read_surface(in, m);
    return m;
  }

 private:
  static bool is_glass(const tinyobj::material_t& in) {
    return in.alpha_texname.empty() && (in.illum == 4 || in.illum == 6 || in.illum == 7 ||
                                        in.illum == 9 || in.dissolve < 0.999f);
  }
  // A factor of 0 beside a picture is one that the file does not give.
  static FloatParam share(float value, TextureId picture) {
    const float factor = clamp_to(value, 0, 1);
    return {picture.valid() && factor == 0 ? 1 : factor, picture, 0};
  }

  // What any opaque kind may have.
  void read_surface(const tinyobj::material_t& in, Material& m) {
    m.emission.texture = texture(in, "map_Ke", in.emissive_texname, in.emissive_texopt);
    if (m.emission.texture.valid() && m.emission.value.is_black()) m.emission.value = Rgb{1.0f};
    m.normal_map = texture(in, "norm", in.normal_texname, in.normal_texopt, false);
    if (m.normal_map.valid())
      m.normal_scale = clamp_to(in.normal_texopt.bump_multiplier, -1000, 1000);
    const TextureId mask = texture(in, "map_d", in.alpha_texname, in.alpha_texopt, false);
    if (mask.valid()) m.opacity = {1, mask, has_alpha(mask) ? 3 : kLuminance};
    const std::pair<const char*, const std::string&> left_out[] = {
        {"map_bump", in.bump_texname},
        {"disp", in.displacement_texname},
        {"refl", in.reflection_texname},
        {"map_Ns", in.specular_highlight_texname},
        {"map_Ps", in.sheen_texname}};
    for (const auto& [key, name] : left_out)
      if (!name.empty()) warn(in, std::string(key) + " is left out");
  }
  bool has_alpha(TextureId id) const {
    const Result<PictureInfo> info = read_picture_info(out_.textures[id.value].path, nullptr);
    return info.ok() && info.value().alpha_channel >= 0;
  }

  void warn(const tinyobj::material_t& in, const std::string& text) {
    out_.warnings.push_back("material \"" + in.name + "\": " + text);
  }

  Rgb color(const tinyobj::material_t& in, const char* key, const tinyobj::real_t* v, float hi) {
    const Rgb read{v[0], v[1], v[2]};
    Rgb out;
    for (int i = 0; i < 3; ++i) out[i] = clamp_to(read[i], 0, hi);
    if (!(out == read)) warn(in, std::string(key) + " was brought into range");
    return out;
  }

  TextureId texture(const tinyobj::material_t& in, const std::string& key, std::string name,
                    const tinyobj::texture_option_t& option, bool srgb = true) {
    if (name.empty()) return {};
    std::string as_used = name + (srgb ? " srgb" : " raw");
    for (const float v : {option.scale[0], option.scale[1], option.origin_offset[0],
                          option.origin_offset[1], option.clamp ? 1.0f : 0.0f})
      as_used += " " + std::to_string(v);
    std::replace(name.begin(), name.end(), '\\', '/');
    const auto [it, is_new] =
        ids_.try_emplace(as_used, TextureId(static_cast<uint32_t>(out_.textures.size())));
    if (!is_new) return it->second;
    const Result<std::filesystem::path> path = find_within(folder_, folder_, name);
    if (!path.ok()) {
      warn(in, key + ": " + path.error().message);
      return it->second = TextureId{};
    }
    Texture& texture = out_.textures.emplace_back();
    texture.path = path.value();
    texture.srgb = srgb;
    texture.uv_transform.u = {option.scale[0], 0, option.origin_offset[0]};
    texture.uv_transform.v = {0, option.scale[1], option.origin_offset[1]};
    if (option.clamp) texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
    return it->second;
  }

  const std::filesystem::path& folder_;
  ObjContents& out_;
  std::map<std::string, TextureId> ids_;  // by file and options
};

}  // namespace

void convert_materials(const std::vector<tinyobj::material_t>& materials,
                       const std::filesystem::path& folder, ObjContents& out) {
  Converter converter(folder, out);
  for (const tinyobj::material_t& m : materials) out.materials.push_back(converter.convert(m));
}

}  // namespace qray
