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

int read_channel(const JsonNode& node) {
  constexpr std::string_view kChannels = "rgba";
  const std::string& name = node.string();
  const size_t at = name.size() == 1 ? kChannels.find(name[0]) : std::string_view::npos;
  if (at == std::string_view::npos) node.fail_expected("one of r, g, b, a");
  return static_cast<int>(at);
}

FloatParam read_float(const JsonNode& node, const TextureNames& textures) {
  if (node.is_number()) return {node.number(), {}};
  node.only({"texture", "scale", "channel"});
  const std::optional<JsonNode> scale = node.find("scale"), channel = node.find("channel");
  return {scale ? scale->number() : 1.0f, texture_id(node.get("texture"), textures),
          channel ? read_channel(*channel) : 0};
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

struct Kind {
  const char* type;
  MaterialKind kind;
  std::vector<std::string_view> fields;  // beside those of any kind
};

const Kind& read_kind(const JsonNode& node) {
  static const std::vector<Kind> kinds = {
      {"diffuse", MaterialKind::kDiffuse, {"reflectance"}},
      {"conductor",
       MaterialKind::kConductor,
       {"metal", "eta", "k", "roughness", "anisotropy", "anisotropy_deg", "microfacets",
        "specular"}},
      {"dielectric",
       MaterialKind::kDielectric,
       {"ior", "roughness", "anisotropy", "anisotropy_deg", "microfacets", "specular",
        "transmittance", "absorption"}},
      {"thin_dielectric", MaterialKind::kThinDielectric, {"ior", "specular", "transmittance"}},
      {"plastic",
       MaterialKind::kPlastic,
       {"reflectance", "ior", "roughness", "microfacets", "specular", "nonlinear"}},
      {"principled",
       MaterialKind::kPrincipled,
       {"reflectance",
        "ior",
        "roughness",
        "anisotropy",
        "anisotropy_deg",
        "specular",
        "specular_weight",
        "metallic",
        "transmission",
        "thin",
        "disney",
        "absorption",
        "clearcoat",
        "clearcoat_roughness",
        "sheen",
        "sheen_roughness",
        "anisotropy_directions",
        "diffuse_transmission",
        "diffuse_transmission_color",
        "iridescence",
        "film_ior",
        "film_nm",
        "film_least_nm",
        "own_coat_normal",
        "coat_normal_map"}},
      {"blend", MaterialKind::kBlend, {"first", "second", "weight"}},
  };
  const JsonNode type = node.get("type");
  std::string known;
  for (const Kind& kind : kinds) {
    if (type.string() == kind.type) return kind;
    known += (known.empty() ? "" : ", ") + std::string(kind.type);
  }
  type.fail_expected("one of " + known);
}

float read_normal_map(const JsonNode& node, const TextureNames& textures, TextureId& map) {
  node.only({"texture", "scale"});
  map = texture_id(node.get("texture"), textures);
  const std::optional<JsonNode> scale = node.find("scale");
  return scale ? scale->number() : 1;
}

void read_any_kind(const JsonNode& node, const TextureNames& textures, Material& material) {
  if (const auto v = node.find("emission")) material.emission = read_color(*v, textures);
  if (const auto v = node.find("emission_two_sided")) material.emission_two_sided = v->boolean();
  if (const auto v = node.find("opacity")) material.opacity = read_float(*v, textures);
  if (const auto v = node.find("alpha_cutoff")) material.alpha_cutoff = v->number();
  if (const auto v = node.find("two_sided")) material.two_sided = v->boolean();
  if (const auto v = node.find("normal_map"))
    material.normal_scale = read_normal_map(*v, textures, material.normal_map);
  if (const auto v = node.find("bump_map")) {
    if (v->is_number()) v->fail_expected("an object with \"texture\"");
    material.bump_map = read_float(*v, textures);
  }
}

void read_blend(const JsonNode& node, const TextureNames& textures, const MaterialNames& earlier,
                Material& material) {
  const auto part = [&](const char* key) {
    const JsonNode name = node.get(key);
    const auto it = earlier.find(name.string());
    if (it == earlier.end()) name.fail_expected("the name of a material before this one");
    return it->second;
  };
  material.first = part("first");
  material.second = part("second");
  if (const auto v = node.find("weight")) material.blend_weight = read_float(*v, textures);
}

}  // namespace

Material read_material(const JsonNode& node, const TextureNames& textures,
                       const MaterialNames& earlier) {
  const Kind& kind = read_kind(node);
  std::vector<std::string_view> fields = {
      "name",         "type",     "emission",   "opacity",    "two_sided", "emission_two_sided",
      "alpha_cutoff", "bump_map", "normal_map", "light_group"};
  fields.insert(fields.end(), kind.fields.begin(), kind.fields.end());
  node.only(fields);

  Material m;
  m.name = node.get("name").string();
  m.kind = kind.kind;
  m.light_group = read_light_group(node);
  read_any_kind(node, textures, m);
  if (const auto v = node.find("reflectance")) m.reflectance = read_color(*v, textures);
  if (const auto v = node.find("specular")) m.specular = read_color(*v, textures);
  if (const auto v = node.find("sheen")) m.sheen = read_color(*v, textures);
  if (m.kind == MaterialKind::kDielectric || m.kind == MaterialKind::kThinDielectric) {
    const auto v = node.find("transmittance");
    m.transmittance = v ? read_color(*v, textures) : m.specular;
  }
  const struct {
    const char* key;
    FloatParam& param;
  } numbers[] = {{"roughness", m.roughness},
                 {"anisotropy", m.anisotropy},
                 {"specular_weight", m.specular_weight},
                 {"metallic", m.metallic},
                 {"transmission", m.transmission},
                 {"clearcoat", m.clearcoat},
                 {"clearcoat_roughness", m.clearcoat_roughness},
                 {"sheen_roughness", m.sheen_roughness},
                 {"diffuse_transmission", m.diffuse_transmission},
                 {"iridescence", m.iridescence},
                 {"film_nm", m.film_nm}};
  for (const auto& [key, param] : numbers)
    if (const auto v = node.find(key)) param = read_float(*v, textures);
  if (const auto v = node.find("microfacets")) {
    if (v->string() == "beckmann")
      m.microfacets = Microfacets::kBeckmann;
    else if (v->string() != "ggx")
      v->fail_expected("one of ggx, beckmann");
  }
  if (const auto v = node.find("anisotropy_deg"))
    m.anisotropy_rad = v->number(-360, 360) * (kPi / 180);
  if (const auto v = node.find("anisotropy_directions")) m.anisotropy_directions = v->boolean();
  if (const auto v = node.find("diffuse_transmission_color"))
    m.diffuse_transmission_color = read_color(*v, textures);
  if (const auto v = node.find("film_ior")) m.film_ior = v->number();
  if (const auto v = node.find("film_least_nm")) m.film_least_nm = v->number();
  if (const auto v = node.find("coat_normal_map")) {
    m.coat_normal_scale = read_normal_map(*v, textures, m.coat_normal_map);
    m.own_coat_normal = true;
  }
  if (const auto v = node.find("own_coat_normal")) m.own_coat_normal = v->boolean();
  if (const auto v = node.find("ior")) m.ior = v->number();
  if (const auto v = node.find("absorption")) m.absorption = v->number_or_rgb();
  if (const auto v = node.find("thin")) m.thin = v->boolean();
  if (const auto v = node.find("disney")) m.disney = v->boolean();
  if (const auto v = node.find("nonlinear")) m.nonlinear = v->boolean();
  if (m.kind == MaterialKind::kConductor) read_metal(node, m);
  if (m.kind == MaterialKind::kBlend) read_blend(node, textures, earlier, m);
  return m;
}

}  // namespace qray
