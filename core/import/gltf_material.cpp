#include "core/import/gltf_material.h"

#include <algorithm>
#include <cmath>

#include "core/scene/value_ranges.h"

namespace qray {
namespace {

constexpr float kF0 = 0.04f;  // of index 1.5

}  // namespace

const GltfMaterials::Converted& GltfMaterials::convert(int index) {
  auto it = known_.find(index);
  if (it == known_.end()) it = known_.emplace(index, convert_new(index)).first;
  return it->second;
}

GltfMaterials::Converted GltfMaterials::convert_new(int index) {
  Material m;
  m.kind = MaterialKind::kPrincipled;
  m.reflectance = {Rgb{1.0f}, {}};
  m.metallic.value = 1;
  m.roughness.value = 1;
  Converted out;
  if (index < 0) {
    m.name = "glTF's default";
  } else {
    const JsonNode node = import_.document.at("materials", index);
    import_.expect_extensions(
        node,
        {"KHR_materials_anisotropy", "KHR_materials_clearcoat",
         "KHR_materials_diffuse_transmission", "KHR_materials_emissive_strength",
         "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_pbrSpecularGlossiness",
         "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission",
         "KHR_materials_unlit", "KHR_materials_volume"});
    if (const auto name = node.find("name")) m.name = name->string();
    uv_sets_.clear();
    // First, since the mesh's tangents are of the first set.
    if (const auto set = textures_.uv_set(node, "normalTexture")) uv_sets_.push_back(*set);
    out.unlit = find_extension(node, "KHR_materials_unlit").has_value();
    const auto glossy = find_extension(node, "KHR_materials_pbrSpecularGlossiness");
    if (glossy && !out.unlit)
      read_specular_glossiness(*glossy, m);
    else if (const auto metallic = node.find("pbrMetallicRoughness"))
      read_metallic_roughness(*metallic, m);
    read_alpha(node, m);
    if (out.unlit) {
      make_unlit(m);
    } else {
      read_layers(node, m);
      read_clearcoat(node, m);
      read_iridescence(node, m);
      read_transmission(node, m);
      read_emission(node, m);
      m.normal_scale = normal_map(node, "normalTexture", m.normal_map);
    }
    out.uv_sets = uv_sets_;
    const auto mode = node.find("alphaMode");
    out.opaque = !mode || mode->string() == "OPAQUE";
  }
  std::vector<Material>& materials = import_.out.scene.materials;
  out.id = MaterialId(static_cast<uint32_t>(materials.size()));
  materials.push_back(std::move(m));
  return out;
}

void GltfMaterials::read_metallic_roughness(const JsonNode& node, Material& m) {
  m.reflectance.texture = texture(node, "baseColorTexture", /*srgb=*/true);
  if (const auto factor = node.find("baseColorFactor")) {
    if (factor->size() != 4) factor->fail_expected("an array of 4 numbers");
    for (int i = 0; i < 4; ++i) {
      const float v = factor->at(static_cast<size_t>(i)).number(0, 1);
      (i < 3 ? m.reflectance.value[i] : m.opacity.value) = v;
    }
  }
  m.metallic.value = share(node, "metallicFactor", 1);
  m.roughness.value = share(node, "roughnessFactor", 1);
  const TextureId both = texture(node, "metallicRoughnessTexture", /*srgb=*/false);
  m.metallic.texture = m.roughness.texture = both;
  m.metallic.channel = 2;
  m.roughness.channel = 1;
}

// The specular colour is F0. The extension scales what is diffuse by what its greatest channel
// leaves; of a textured one the facets' share alone is taken.
void GltfMaterials::read_specular_glossiness(const JsonNode& node, Material& m) {
  m.metallic.value = 0;
  m.reflectance.texture = texture(node, "diffuseTexture", /*srgb=*/true);
  if (const auto factor = node.find("diffuseFactor")) {
    if (factor->size() != 4) factor->fail_expected("an array of 4 numbers");
    for (int i = 0; i < 4; ++i) {
      const float v = factor->at(static_cast<size_t>(i)).number(0, 1);
      (i < 3 ? m.reflectance.value[i] : m.opacity.value) = v;
    }
  }
  m.specular = {color(node, "specularFactor", Rgb{1.0f}, 1) / kF0,
                texture(node, "specularGlossinessTexture", /*srgb=*/true)};
  const float glossiness = share(node, "glossinessFactor", 1);
  m.roughness.value = 1 - glossiness;
  if (!m.specular.texture.valid()) {
    m.reflectance.value =
        m.reflectance.value * (1 - max_component(color(node, "specularFactor", Rgb{1.0f}, 1)));
    return;
  }
  const TextureId roughness = textures_.complement_of_alpha(node.get("specularGlossinessTexture"),
                                                            m.specular.texture, glossiness);
  if (roughness.valid()) m.roughness = {1, roughness};
}

void GltfMaterials::read_layers(const JsonNode& node, Material& m) {
  if (const auto e = find_extension(node, "KHR_materials_ior")) {
    if (const auto ior = e->find("ior")) {
      m.ior = ior->number(0, 1e6f);
      if (m.ior == 0) {  // reflects all: the index is infinite
        m.ior = 1.5f;
        m.specular.value = m.specular.value / kF0;
      } else if (m.ior < 1 || m.ior > 4) {
        import_.warn(*ior, "an index outside 1..4 is drawn as the nearest");
        m.ior = std::clamp(m.ior, 1.0f, 4.0f);
      }
    }
  }
  if (const auto e = find_extension(node, "KHR_materials_specular")) {
    m.specular_weight = {share(*e, "specularFactor", 1),
                         texture(*e, "specularTexture", /*srgb=*/false), 3};
    const Rgb tint = color(*e, "specularColorFactor", Rgb{1.0f}, 1000);
    for (int i = 0; i < 3; ++i)
      m.specular.value[i] = std::min(m.specular.value[i] * tint[i], 1000.0f);
    m.specular.texture = texture(*e, "specularColorTexture", /*srgb=*/true);
  }
  if (const auto e = find_extension(node, "KHR_materials_anisotropy")) {
    m.anisotropy = {share(*e, "anisotropyStrength", 0),
                    texture(*e, "anisotropyTexture", /*srgb=*/false), 2};
    if (const auto turn = e->find("anisotropyRotation"))
      m.anisotropy_rad = std::remainder(turn->number(-kMaxCoordinate, kMaxCoordinate), 2 * kPi);
    m.anisotropy_directions = m.anisotropy.texture.valid();
  }
  if (const auto e = find_extension(node, "KHR_materials_sheen")) {
    m.sheen = {color(*e, "sheenColorFactor", Rgb{0.0f}, 1),
               texture(*e, "sheenColorTexture", /*srgb=*/true)};
    m.sheen_roughness = {share(*e, "sheenRoughnessFactor", 0),
                         texture(*e, "sheenRoughnessTexture", /*srgb=*/false), 3};
  }
}

// Without a map of its own the coat has the mesh's normals, whatever those below it are.
void GltfMaterials::read_clearcoat(const JsonNode& node, Material& m) {
  const auto e = find_extension(node, "KHR_materials_clearcoat");
  if (!e) return;
  m.clearcoat = {share(*e, "clearcoatFactor", 0), texture(*e, "clearcoatTexture", /*srgb=*/false),
                 0};
  m.clearcoat_roughness = {share(*e, "clearcoatRoughnessFactor", 0),
                           texture(*e, "clearcoatRoughnessTexture", /*srgb=*/false), 1};
  m.coat_normal_scale = normal_map(*e, "clearcoatNormalTexture", m.coat_normal_map);
  m.own_coat_normal = true;
}

void GltfMaterials::read_iridescence(const JsonNode& node, Material& m) {
  const auto e = find_extension(node, "KHR_materials_iridescence");
  if (!e) return;
  m.iridescence = {share(*e, "iridescenceFactor", 0),
                   texture(*e, "iridescenceTexture", /*srgb=*/false), 0};
  if (const auto v = e->find("iridescenceIor")) m.film_ior = v->number(1, 4);
  if (const auto v = e->find("iridescenceThicknessMaximum"))
    m.film_nm.value = v->number(0, kMaxFilmNm);
  if (const auto v = e->find("iridescenceThicknessMinimum"))
    m.film_least_nm = v->number(0, kMaxFilmNm);
  m.film_nm.texture = texture(*e, "iridescenceThicknessTexture", /*srgb=*/false);
  m.film_nm.channel = 1;
}

void GltfMaterials::read_transmission(const JsonNode& node, Material& m) {
  const auto e = find_extension(node, "KHR_materials_transmission");
  if (e)
    m.transmission = {share(*e, "transmissionFactor", 0),
                      texture(*e, "transmissionTexture", /*srgb=*/false), 0};
  if (const auto diffuse = find_extension(node, "KHR_materials_diffuse_transmission")) {
    m.diffuse_transmission = {share(*diffuse, "diffuseTransmissionFactor", 0),
                              texture(*diffuse, "diffuseTransmissionTexture", /*srgb=*/false), 3};
    m.diffuse_transmission_color = {
        color(*diffuse, "diffuseTransmissionColorFactor", Rgb{1.0f}, 1),
        texture(*diffuse, "diffuseTransmissionColorTexture", /*srgb=*/true)};
  }
  m.thin = true;
  const auto volume = find_extension(node, "KHR_materials_volume");
  if (!volume) return;
  const auto thickness = volume->find("thicknessFactor");
  if (!thickness || thickness->number(0, kMaxCoordinate) == 0) return;
  m.thin = false;
  const auto distance = volume->find("attenuationDistance");
  if (!distance) return;
  const Rgb passed = color(*volume, "attenuationColor", Rgb{1.0f}, 1);
  const float metres = distance->number(1e-9f, std::numeric_limits<float>::infinity());
  for (int i = 0; i < 3; ++i) {
    const float kept = std::max(passed[i], 1e-6f);
    m.absorption[i] = std::min(-std::log(kept) / metres, kMaxAbsorption) + 0.0f;
  }
}

void GltfMaterials::read_emission(const JsonNode& node, Material& m) {
  const Rgb factor = color(node, "emissiveFactor", Rgb{0.0f}, kMaxRadiance);
  float strength = 1;
  if (const auto e = find_extension(node, "KHR_materials_emissive_strength"))
    if (const auto v = e->find("emissiveStrength")) strength = v->number(0, kMaxRadiance);
  for (int i = 0; i < 3; ++i) m.emission.value[i] = std::min(factor[i] * strength, kMaxRadiance);
  m.emission.texture = texture(node, "emissiveTexture", /*srgb=*/true);
  const auto both = node.find("doubleSided");
  m.emission_two_sided = both && both->boolean();
}

// After the base colour: its alpha is the opacity.
void GltfMaterials::read_alpha(const JsonNode& node, Material& m) {
  const auto mode = node.find("alphaMode");
  const std::string name = mode ? mode->string() : "OPAQUE";
  if (name == "OPAQUE") {
    m.opacity.value = 1;
    return;
  }
  if (name != "MASK" && name != "BLEND") mode->fail_expected("OPAQUE, MASK or BLEND");
  m.opacity.texture = m.reflectance.texture;
  m.opacity.channel = 3;
  if (name == "BLEND") return;
  const auto cutoff = node.find("alphaCutoff");
  m.alpha_cutoff = cutoff ? cutoff->number(0, kMaxRadiance) : 0.5f;
  // Every alpha reaches 0, none a value over 1.
  if (m.alpha_cutoff == 0 || m.alpha_cutoff > 1) {
    m.opacity = {m.alpha_cutoff == 0 ? 1.0f : 0.0f};
    m.alpha_cutoff = 0;
  }
}

// Returns its scale.
float GltfMaterials::normal_map(const JsonNode& node, std::string_view key, TextureId& map) {
  map = texture(node, key, /*srgb=*/false);
  if (!map.valid()) return 1;
  const auto scale = node.get(key).find("scale");
  return scale ? scale->number(-kMaxSlope, kMaxSlope) : 1;
}

// Black, and shining in its colour on both sides.
void GltfMaterials::make_unlit(Material& m) {
  m.kind = MaterialKind::kDiffuse;
  m.emission = m.reflectance;
  m.emission_two_sided = true;
  m.reflectance = {Rgb{0.0f}, {}};
  m.metallic = {};
  m.roughness = {};
}

float GltfMaterials::share(const JsonNode& node, std::string_view key, float fallback) {
  const auto value = node.find(key);
  return value ? value->number(0, 1) : fallback;
}

Rgb GltfMaterials::color(const JsonNode& node, std::string_view key, Rgb fallback, float most) {
  const auto value = node.find(key);
  if (!value) return fallback;
  if (value->size() != 3) value->fail_expected("an array of 3 numbers");
  return {value->at(0).number(0, most), value->at(1).number(0, most), value->at(2).number(0, most)};
}

// A mesh has two sets of uvs: the first two that the material's textures ask for.
TextureId GltfMaterials::texture(const JsonNode& node, std::string_view key, bool srgb) {
  const std::optional<int> asked = textures_.uv_set(node, key);
  if (!asked) return {};
  auto set = std::find(uv_sets_.begin(), uv_sets_.end(), *asked);
  if (set == uv_sets_.end() && uv_sets_.size() < 2) set = uv_sets_.insert(set, *asked);
  if (set == uv_sets_.end()) {
    set = uv_sets_.begin();
    import_.warn(node.get(key), "is drawn with TEXCOORD_" + std::to_string(*set) +
                                    ", not TEXCOORD_" + std::to_string(*asked) +
                                    ": the material's textures ask for more than two sets of uvs");
  }
  return textures_.find(node, key, srgb, set != uv_sets_.begin());
}

}  // namespace qray
