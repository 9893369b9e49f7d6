#include "core/import/json_scene.h"

namespace qray {
namespace {

// Complex indices of refraction at 630, 550 and 460 nm, interpolated in published measurements:
// copper, gold and silver of Johnson and Christy 1972, aluminium of Hagemann et al. 1974.
struct Metal {
  const char* name;
  Rgb eta, k;
};
constexpr Metal kMetals[] = {
    {"aluminium", {1.356f, 0.998f, 0.674f}, {7.38f, 6.508f, 5.515f}},
    {"copper", {0.275f, 1.007f, 1.244f}, {3.373f, 2.582f, 2.435f}},
    {"gold", {0.188f, 0.424f, 1.349f}, {3.403f, 2.472f, 1.885f}},
    {"silver", {0.0569f, 0.0596f, 0.0444f}, {4.254f, 3.597f, 2.751f}},
};

TextureId texture_id(const JsonNode& name, const TextureNames& textures) {
  const auto it = textures.find(name.string());
  if (it == textures.end()) name.fail_expected("the name of a texture");
  return it->second;
}

ColorParam read_color(const JsonNode& node, const TextureNames& textures) {
  if (node.is_number() || node.is_array()) return {node.number_or_rgb(), {}};
  node.only({"texture", "scale"});
  const std::optional<JsonNode> scale = node.find("scale");
  return {scale ? scale->number_or_rgb() : Rgb{1.0f}, texture_id(node.get("texture"), textures)};
}

FloatParam read_float(const JsonNode& node, const TextureNames& textures) {
  if (node.is_number()) return {node.number(), {}};
  node.only({"texture", "scale"});
  const std::optional<JsonNode> scale = node.find("scale");
  return {scale ? scale->number() : 1.0f, texture_id(node.get("texture"), textures)};
}

void read_metal(const JsonNode& node, Material& material) {
  const std::optional<JsonNode> preset = node.find("metal");
  if (!preset) {
    material.eta = node.get("eta").number_or_rgb();
    material.k = node.get("k").number_or_rgb();
    return;
  }
  for (const char* key : {"eta", "k"})
    if (node.has(key)) node.get(key).fail("expected either \"metal\" or \"eta\" and \"k\"");
  std::string known;
  for (const Metal& metal : kMetals) {
    if (preset->string() == metal.name) {
      material.eta = metal.eta;
      material.k = metal.k;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(metal.name);
  }
  preset->fail_expected("one of " + known);
}

MaterialKind read_kind(const JsonNode& node) {
  const JsonNode type = node.get("type");
  if (type.string() == "diffuse") {
    node.only({"name", "type", "emission", "emission_two_sided", "reflectance"});
    return MaterialKind::kDiffuse;
  }
  if (type.string() == "conductor") {
    node.only({"name", "type", "emission", "emission_two_sided", "metal", "eta", "k", "roughness",
               "specular"});
    return MaterialKind::kConductor;
  }
  if (type.string() == "dielectric") {
    node.only({"name", "type", "emission", "emission_two_sided", "ior", "roughness", "specular"});
    return MaterialKind::kDielectric;
  }
  if (type.string() == "plastic") {
    node.only({"name", "type", "emission", "emission_two_sided", "reflectance", "ior", "roughness",
               "specular"});
    return MaterialKind::kPlastic;
  }
  type.fail_expected("one of diffuse, conductor, dielectric, plastic");
}

}  // namespace

Material read_material(const JsonNode& node, const TextureNames& textures) {
  Material material;
  material.name = node.get("name").string();
  material.kind = read_kind(node);
  if (const auto v = node.find("reflectance")) material.reflectance = read_color(*v, textures);
  if (const auto v = node.find("roughness")) material.roughness = read_float(*v, textures);
  if (const auto v = node.find("ior")) material.ior = v->number();
  if (const auto v = node.find("specular")) material.specular.value = v->number_or_rgb();
  if (const auto v = node.find("emission")) material.emission.value = v->number_or_rgb();
  if (const auto v = node.find("emission_two_sided")) material.emission_two_sided = v->boolean();
  if (material.kind == MaterialKind::kConductor) read_metal(node, material);
  return material;
}

}  // namespace qray
