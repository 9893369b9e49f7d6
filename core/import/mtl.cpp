#include "core/import/mtl.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <map>

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
      return m;
    }
    m.reflectance = {diffuse, texture(in)};
    if (m.reflectance.texture.valid() && diffuse.is_black()) m.reflectance.value = Rgb{1.0f};
    if (max_component(specular) > 0) {
      m.kind = MaterialKind::kPlastic;
      if (in.ior > 1) m.ior = clamp_to(in.ior, 1.01f, 4);
      const float f0 = sqr((m.ior - 1) / (m.ior + 1));
      for (int i = 0; i < 3; ++i) m.specular.value[i] = std::min(1.0f, specular[i] / f0);
      // Phong's exponent as the GGX alpha of like width; roughness is its root.
      const float alpha = std::sqrt(2 / (2 + clamp_to(in.shininess, 0, 1e6f)));
      m.roughness.value = std::sqrt(alpha);
    }
    return m;
  }

 private:
  static bool is_glass(const tinyobj::material_t& in) {
    return in.illum == 4 || in.illum == 6 || in.illum == 7 || in.illum == 9 || in.dissolve < 0.999f;
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

  TextureId texture(const tinyobj::material_t& in) {
    std::string name = in.diffuse_texname;
    if (name.empty()) return {};
    std::replace(name.begin(), name.end(), '\\', '/');
    const auto [it, is_new] =
        ids_.try_emplace(name, TextureId(static_cast<uint32_t>(out_.textures.size())));
    if (!is_new) return it->second;
    const Result<std::filesystem::path> path = find_within(folder_, folder_, name);
    if (!path.ok()) {
      warn(in, "map_Kd: " + path.error().message);
      return it->second = TextureId{};
    }
    Texture& texture = out_.textures.emplace_back();
    texture.path = path.value();
    if (in.diffuse_texopt.clamp) texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
    return it->second;
  }

  const std::filesystem::path& folder_;
  ObjContents& out_;
  std::map<std::string, TextureId> ids_;
};

}  // namespace

void convert_materials(const std::vector<tinyobj::material_t>& materials,
                       const std::filesystem::path& folder, ObjContents& out) {
  Converter converter(folder, out);
  for (const tinyobj::material_t& m : materials) out.materials.push_back(converter.convert(m));
}

}  // namespace qray
