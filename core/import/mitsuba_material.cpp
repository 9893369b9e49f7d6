#include "core/import/mitsuba_material.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/import/mitsuba_ior.h"

namespace qray {
namespace {

constexpr int kMaxBsdfDepth = 32;  // of BSDFs in BSDFs
// Reflects all light, at every angle.
void make_mirror(Material& m) {
  m.kind = MaterialKind::kConductor;
  m.eta = Rgb{0.0f};
  m.k = Rgb{1.0f};
}

Rgb in_range(Rgb v, float hi) {
  for (int i = 0; i < 3; ++i) v[i] = std::clamp(v[i], 0.0f, hi);
  return v;
}

}  // namespace

MaterialId MitsubaMaterials::add(Material material) {
  std::vector<Material>& materials = import_.out.scene.materials;
  materials.push_back(std::move(material));
  return MaterialId(static_cast<uint32_t>(materials.size() - 1));
}

MitsubaMaterials::Converted MitsubaMaterials::convert(const MitsubaNode& bsdf) {
  return convert(bsdf, /*two_sided=*/false);
}

MitsubaMaterials::Converted MitsubaMaterials::convert(const MitsubaNode& bsdf, bool two_sided) {
  const std::pair key(&bsdf, two_sided);
  if (const auto it = known_.find(key); it != known_.end()) {
    colored_ = colored_ || it->second.vertex_colors;
    return it->second;
  }
  if (++depth_ > kMaxBsdfDepth) bsdf.fail("expected BSDFs of at most 32 levels, no cycles");
  const bool colored_before = std::exchange(colored_, false);
  Converted converted = convert_new(bsdf, two_sided);
  converted.vertex_colors = textures_.take_vertex_colors() || colored_;
  colored_ = colored_before || converted.vertex_colors;
  --depth_;
  if (converted.material.name.empty() || !bsdf.id.empty())
    converted.material.name = bsdf.id.empty() ? bsdf.type + " at " + bsdf.where : bsdf.id;
  known_.emplace(key, converted);
  return converted;
}

MitsubaMaterials::Converted MitsubaMaterials::convert_new(const MitsubaNode& bsdf, bool two_sided) {
  const std::string& type = bsdf.type;
  if (type == "dielectric") return dielectric(bsdf, /*rough=*/false);
  if (type == "roughdielectric") return dielectric(bsdf, /*rough=*/true);
  if (type == "twosided" || type == "mask" || type == "bumpmap" || type == "normalmap" ||
      type == "coating" || type == "roughcoating")
    return wrapper(bsdf, two_sided);
  Material m;
  if (type == "diffuse" || type == "roughdiffuse") {
    if (type == "roughdiffuse") import_.warn(bsdf, "roughdiffuse is drawn as diffuse");
    const bool old_name = find_parameter(bsdf, "diffuse_reflectance") != nullptr;
    m.reflectance =
        textures_.find_color(bsdf, old_name ? "diffuse_reflectance" : "reflectance", Rgb{0.5f});
    if (type == "diffuse") import_.expect_only(bsdf, {"reflectance", "diffuse_reflectance"});
  } else if (type == "thindielectric") {
    import_.expect_only(bsdf,
                        {"int_ior", "ext_ior", "specular_reflectance", "specular_transmittance"});
    const double ior = relative_ior(bsdf, "bk7");
    m.kind = MaterialKind::kThinDielectric;
    m.ior = static_cast<float>(std::clamp(std::max(ior, 1 / ior), 1.0, 4.0));
    m.specular = textures_.find_color(bsdf, "specular_reflectance", Rgb{1.0f});
    m.transmittance = textures_.find_color(bsdf, "specular_transmittance", Rgb{1.0f});
  } else if (type == "conductor" || type == "roughconductor") {
    m = conductor(bsdf, type == "roughconductor");
  } else if (type == "plastic" || type == "roughplastic") {
    m = plastic(bsdf, type == "roughplastic");
  } else if (type == "principled" || type == "disney") {
    m = principled(bsdf);
    two_sided = two_sided || m.transmission.value > 0;
  } else if (type == "phong" || type == "ward") {
    m = glossy_over_diffuse(bsdf, two_sided);
  } else if (type == "blendbsdf") {
    m = blend(bsdf, two_sided);
  } else if (type == "mixturebsdf") {
    m = mixture(bsdf, two_sided);
  } else if (type == "null") {
    m.opacity.value = 0;
  } else {
    return {unknown(bsdf)};
  }
  m.two_sided = two_sided;
  return {m};
}

// BSDFs that change another one.
MitsubaMaterials::Converted MitsubaMaterials::wrapper(const MitsubaNode& bsdf, bool two_sided) {
  if (bsdf.type == "twosided") {
    if (nested(bsdf).size() > 1) import_.warn(bsdf, "the BSDF of the back is left out");
    return convert(only_nested(bsdf), true);
  }
  Converted out = convert(only_nested(bsdf), two_sided);
  Material& m = out.material;
  if (bsdf.type == "mask") {
    const FloatParam opacity = textures_.find_opacity(bsdf);
    if (!m.opacity.texture.valid() && m.opacity.value == 1)
      m.opacity = opacity;
    else if (!opacity.texture.valid())
      m.opacity.value *= opacity.value;
    else
      import_.warn(bsdf, "a mask within a mask is left out");
    return out;
  }
  if (bsdf.type == "coating" || bsdf.type == "roughcoating") {
    if (m.kind == MaterialKind::kDiffuse) {
      const ColorParam base = m.reflectance;
      Material coat = plastic(bsdf, bsdf.type == "roughcoating");
      m.kind = MaterialKind::kPlastic;
      m.reflectance = base;
      m.ior = coat.ior;
      m.roughness = coat.roughness;
      m.specular = coat.specular;
      m.nonlinear = true;
    }
    import_.warn(bsdf, m.kind == MaterialKind::kPlastic ? bsdf.type + " is drawn as plastic"
                                                        : "the coat is left out");
    return out;
  }
  const bool bump = bsdf.type == "bumpmap";
  for (const MitsubaNode& child : bsdf.children) {
    const MitsubaNode& node = import_.document.resolve(child);
    if (node.tag != "texture") continue;
    const ColorParam map = textures_.read(node);
    if (!map.texture.valid()) break;
    if (bump) {
      const float scale = static_cast<float>(find_number(bsdf, "scale").value_or(1));
      m.bump_map = {luminance(map.value) * scale, map.texture, kLuminance};
    } else {
      m.normal_map = textures_.as_numbers(map.texture);
    }
    return out;
  }
  import_.warn(bsdf, "has no map that can be read, and changes nothing");
  return out;
}

Material MitsubaMaterials::conductor(const MitsubaNode& bsdf, bool rough) {
  import_.expect_only(bsdf, {"material", "eta", "k", "ext_eta", "specular_reflectance", "alpha",
                             "alpha_u", "alpha_v", "distribution", "sample_visible"});
  Material m;
  m.kind = MaterialKind::kConductor;
  const std::string* name = find_text(bsdf, "material");
  const std::string fallback = import_.document.version >= 2 ? "none" : "Cu";
  std::optional<ComplexIor> ior = find_complex_ior(name ? *name : fallback);
  if (!ior) {
    import_.warn(*find_parameter(bsdf, "material"),
                 "the metal \"" + *name + "\" is not known and drawn as copper");
    ior = find_complex_ior("Cu");
  }
  const bool given = find_parameter(bsdf, "eta") || find_parameter(bsdf, "k");
  m.eta = find_color(bsdf, "eta", ior->eta, ColorUse::kIndex, import_);
  m.k = find_color(bsdf, "k", ior->k, ColorUse::kIndex, import_);
  const bool mirror = !given && (name ? *name : fallback) == "none";
  if (!mirror && import_.document.version < 2) {
    const float outside = static_cast<float>(1 / find_ior_of(bsdf, "ext_eta", "air"));
    m.eta = m.eta * outside;
    m.k = m.k * outside;
  }
  m.eta = in_range(m.eta, 20);
  m.k = in_range(m.k, 20);
  m.specular = textures_.find_color(bsdf, "specular_reflectance", Rgb{1.0f});
  if (rough) read_roughness(bsdf, m);
  return m;
}

MitsubaMaterials::Converted MitsubaMaterials::dielectric(const MitsubaNode& bsdf, bool rough) {
  import_.expect_only(bsdf, {"int_ior", "ext_ior", "specular_reflectance", "specular_transmittance",
                             "alpha", "alpha_u", "alpha_v", "distribution", "sample_visible"});
  Converted out;
  Material& m = out.material;
  m.kind = MaterialKind::kDielectric;
  const double ior = relative_ior(bsdf, "bk7");
  out.inside_out = ior < 1;
  m.ior = static_cast<float>(std::clamp(std::max(ior, 1 / ior), 1.0, 4.0));
  m.specular = textures_.find_color(bsdf, "specular_reflectance", Rgb{1.0f});
  m.transmittance = textures_.find_color(bsdf, "specular_transmittance", Rgb{1.0f});
  if (rough) read_roughness(bsdf, m);
  return out;
}

Material MitsubaMaterials::plastic(const MitsubaNode& bsdf, bool rough) {
  if (bsdf.type.find("plastic") != std::string::npos)
    import_.expect_only(bsdf, {"int_ior", "ext_ior", "specular_reflectance", "diffuse_reflectance",
                               "nonlinear", "alpha", "distribution", "sample_visible"});
  Material m;
  m.kind = MaterialKind::kPlastic;
  const double ior = relative_ior(bsdf, bsdf.type.ends_with("coating") ? "bk7" : "polypropylene");
  if (ior < 1) import_.warn(bsdf, "a coat thinner than what is outside is drawn with index 1");
  m.ior = static_cast<float>(std::clamp(ior, 1.0, 4.0));
  m.reflectance = textures_.find_color(bsdf, "diffuse_reflectance", Rgb{0.5f});
  m.specular = textures_.find_color(bsdf, "specular_reflectance", Rgb{1.0f});
  m.nonlinear = find_flag(bsdf, "nonlinear").value_or(false);
  if (rough) read_roughness(bsdf, m);
  return m;
}

Material MitsubaMaterials::principled(const MitsubaNode& bsdf) {
  import_.expect_only(
      bsdf, {"base_color", "roughness", "anisotropic", "metallic", "spec_trans", "eta", "specular",
             "clearcoat", "clearcoat_gloss", "spec_tint", "sheen", "sheen_tint"});
  Material m;
  m.kind = MaterialKind::kPrincipled;
  m.disney = true;
  m.reflectance = textures_.find_color(bsdf, "base_color", Rgb{0.5f});
  m.roughness = textures_.find_share(bsdf, "roughness", 0.5f);
  // Burley 2012, "Physically Based Shading at Disney", section 5.4.
  if (const float share = textures_.find_share(bsdf, "anisotropic", 0).value; share > 0) {
    const float aspect = std::sqrt(1 - 0.9f * std::min(share, 1.0f));
    const float alpha = sqr(m.roughness.value);
    if (m.roughness.texture.valid())
      import_.warn(*find_parameter(bsdf, "anisotropic"),
                   "anisotropic is left out where the roughness is a texture");
    else
      set_roughness(m, std::min(alpha / aspect, 1.0f), alpha * aspect);
  }
  m.metallic = textures_.find_share(bsdf, "metallic", 0);
  m.transmission = textures_.find_share(bsdf, "spec_trans", 0);
  m.clearcoat = textures_.find_share(bsdf, "clearcoat", 0);
  m.clearcoat.value *= 0.25f;  // Disney's coat reflects a quarter of a real one
  const float gloss = textures_.find_share(bsdf, "clearcoat_gloss", 0).value;
  m.clearcoat_roughness.value = std::sqrt(std::lerp(0.1f, 0.001f, gloss));
  // `specular` 0..1 is a reflectance of 0..8 %.
  const double root =
      std::sqrt(0.08 * std::clamp(find_number(bsdf, "specular").value_or(0.5), 0.0, 1.0));
  const double ior = find_number(bsdf, "eta").value_or((1 + root) / (1 - root));
  m.ior = static_cast<float>(std::clamp(ior, 1.0, 4.0));
  m.specular.value = tinted(bsdf, "spec_tint", m.reflectance);
  m.sheen = textures_.find_color(bsdf, "sheen", Rgb{0.0f});
  if (max_component(m.sheen.value) > 0)
    m.sheen.value = m.sheen.value * tinted(bsdf, "sheen_tint", m.reflectance);
  return m;
}

// White, by this share in the hue of the base colour.
Rgb MitsubaMaterials::tinted(const MitsubaNode& bsdf, const char* name, const ColorParam& base) {
  const FloatParam share = textures_.find_share(bsdf, name, 0);
  if (!(share.value > 0)) return Rgb{1.0f};
  if (base.texture.valid() || share.texture.valid()) {
    import_.warn(*find_parameter(bsdf, name),
                 std::string(name) + " is left out where it or the base colour is a texture");
    return Rgb{1.0f};
  }
  const float y = luminance(base.value);
  return lerp(std::min(share.value, 1.0f), Rgb{1.0f}, y > 0 ? base.value * (1 / y) : Rgb{1.0f});
}

// A share of mirror-like reflection, the rest diffuse.
Material MitsubaMaterials::glossy_over_diffuse(const MitsubaNode& bsdf, bool two_sided) {
  import_.warn(bsdf, bsdf.type + " is drawn as a blend of diffuse and GGX reflection");
  const bool phong = bsdf.type == "phong";
  Material base, gloss;
  base.name = "base of " + bsdf.where;
  gloss.name = "gloss of " + bsdf.where;
  base.two_sided = gloss.two_sided = two_sided;
  base.reflectance = textures_.find_color(bsdf, "diffuse_reflectance", Rgb{0.5f});
  make_mirror(gloss);
  gloss.specular = textures_.find_color(bsdf, "specular_reflectance", Rgb{0.2f});
  if (phong) {
    const double exponent = std::clamp(find_number(bsdf, "exponent").value_or(30), 0.0, 1e6);
    gloss.roughness.value = static_cast<float>(std::pow(2 / (exponent + 2), 0.25));
  } else {
    textures_.find_roughness(bsdf, gloss);
  }
  // f = (1 - w) kd / (1 - w) + w ks / w.
  const float kd = max_component(base.reflectance.value), ks = max_component(gloss.specular.value);
  const float w = std::clamp(ks / std::max(kd + ks, 1e-6f), 0.0f, 1.0f);
  if (w < 1) base.reflectance.value = in_range(base.reflectance.value * (1 / (1 - w)), 1);
  if (w > 0) gloss.specular.value = in_range(gloss.specular.value * (1 / w), 1);
  Material m;
  m.kind = MaterialKind::kBlend;
  m.first = add(base);
  m.second = add(gloss);
  m.blend_weight = {w, {}, 0};
  return m;
}

Material MitsubaMaterials::blend(const MitsubaNode& bsdf, bool two_sided) {
  const std::vector<const MitsubaNode*> parts = nested(bsdf);
  if (parts.size() != 2) bsdf.fail("expected two BSDFs to blend");
  Material m;
  m.kind = MaterialKind::kBlend;
  m.first = add(convert(*parts[0], two_sided).material);
  m.second = add(convert(*parts[1], two_sided).material);
  m.blend_weight = textures_.find_share(bsdf, "weight", 0.5f);
  return m;
}

// Weights that may sum to less than 1: what is left absorbs.
Material MitsubaMaterials::mixture(const MitsubaNode& bsdf, bool two_sided) {
  const std::vector<const MitsubaNode*> parts = nested(bsdf);
  const MitsubaNode* weights_node = find_parameter(bsdf, "weights");
  if (!weights_node) bsdf.fail("expected \"weights\"");
  const std::vector<double> weights = parse_numbers(*weights_node, weights_node->need("value"));
  if (weights.size() != parts.size() || parts.empty())
    weights_node->fail("expected as many weights as BSDFs");
  Material sum;  // of the parts so far, of weight `total`
  sum.reflectance.value = Rgb{0.0f};
  double total = std::max(0.0, 1 - std::accumulate(weights.begin(), weights.end(), 0.0));
  for (size_t i = 0; i < parts.size(); ++i) {
    if (!(weights[i] >= 0)) weights_node->fail("expected weights from 0");
    total += weights[i];
    Material m;
    m.kind = MaterialKind::kBlend;
    m.two_sided = two_sided;
    sum.name = "part of " + bsdf.where;
    m.first = add(sum);
    m.second = add(convert(*parts[i], two_sided).material);
    m.blend_weight = {total > 0 ? static_cast<float>(weights[i] / total) : 0, {}, 0};
    sum = m;
  }
  return sum;
}

Material MitsubaMaterials::unknown(const MitsubaNode& bsdf) {
  Material m;
  for (const char* name : {"diffuse_reflectance", "reflectance", "base_color", "transmittance"}) {
    if (!find_parameter(bsdf, name)) continue;
    m.reflectance = textures_.find_color(bsdf, name, Rgb{0.5f});
    break;
  }
  import_.warn(bsdf, "BSDFs of type \"" + bsdf.type + "\" are drawn as diffuse");
  return m;
}

std::vector<const MitsubaNode*> MitsubaMaterials::nested(const MitsubaNode& bsdf) const {
  std::vector<const MitsubaNode*> out;
  for (const MitsubaNode& child : bsdf.children) {
    const MitsubaNode& node = import_.document.resolve(child);
    if (node.tag == "bsdf") out.push_back(&node);
  }
  return out;
}

const MitsubaNode& MitsubaMaterials::only_nested(const MitsubaNode& bsdf) {
  const std::vector<const MitsubaNode*> parts = nested(bsdf);
  if (parts.empty()) bsdf.fail("expected a BSDF within " + bsdf.type);
  return *parts[0];
}

double MitsubaMaterials::find_ior_of(const MitsubaNode& bsdf, std::string_view name,
                                     std::string_view fallback) {
  const MitsubaNode* parameter = find_parameter(bsdf, name);
  if (!parameter) return static_cast<double>(*find_ior(fallback));
  const std::string& value = parameter->need("value");
  if (parameter->tag == "string") {
    if (const std::optional<float> known = find_ior(value)) return static_cast<double>(*known);
    parameter->fail("expected the name of a material such as \"bk7\", got \"" + value + "\"");
  }
  const double ior = parse_number(*parameter, value);
  if (!(ior > 0.1 && ior < 20)) parameter->fail("expected an index of 0.1..20");
  return ior;
}

double MitsubaMaterials::relative_ior(const MitsubaNode& bsdf, const char* inside) {
  return find_ior_of(bsdf, "int_ior", inside) / find_ior_of(bsdf, "ext_ior", "air");
}

void MitsubaMaterials::read_roughness(const MitsubaNode& bsdf, Material& material) {
  textures_.find_roughness(bsdf, material);
  const std::string* distribution = find_text(bsdf, "distribution");
  const std::string name = distribution ? *distribution : "beckmann";
  if (name == "ggx") return;
  material.microfacets = Microfacets::kBeckmann;
  if (name != "beckmann") {
    import_.warn(*find_parameter(bsdf, "distribution"),
                 "the distribution \"" + name + "\" is drawn as beckmann");
  }
}

}  // namespace qray
