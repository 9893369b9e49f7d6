// What glTF's materials become.
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

// With textures 0..2 of the pictures p0.png .. p2.png, which are not read.
LoadedScene load_with(const test::SceneFolder& folder, const std::string& material) {
  GltfText text = gltf_triangle();
  for (int i = 0; i < 3; ++i) {
    const std::string name = "p" + std::to_string(i) + ".png";
    folder.write(name, "picture " + name);
    text.json["images"].push_back({{"uri", name}});
    text.json["textures"].push_back({{"source", i}});
  }
  text.json["materials"] = {json::parse(material)};
  return load_gltf(folder, text);
}

const Material& material_of(const LoadedScene& loaded) { return loaded.scene.materials.at(0); }

std::string picture(const LoadedScene& loaded, TextureId id) {
  return id.valid() ? loaded.scene.textures[id.value].path.filename().string() : "none";
}

TEST(GltfMaterial, DefaultsAreTheSpecifications) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive().erase("material");
  for (const LoadedScene& loaded : {load_with(folder, "{}"), load_gltf(folder, text)}) {
    const Material& m = material_of(loaded);
    EXPECT_EQ(m.kind, MaterialKind::kPrincipled);
    EXPECT_EQ(m.reflectance, (ColorParam{Rgb{1.0f}, {}}));
    EXPECT_EQ(m.metallic.value, 1);
    EXPECT_EQ(m.roughness.value, 1);
    EXPECT_EQ(m.ior, 1.5f);
    EXPECT_EQ(m.specular_weight, FloatParam{1.0f});
    EXPECT_EQ(m.specular, (ColorParam{Rgb{1.0f}, {}}));
    EXPECT_EQ(m.opacity, FloatParam{1.0f});
    EXPECT_TRUE(m.two_sided);
    EXPECT_FALSE(m.emits());
  }
}

TEST(GltfMaterial, MetallicRoughness) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"name": "x", "doubleSided": true,
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4],
      "baseColorTexture": {"index": 0}, "metallicFactor": 0.5, "roughnessFactor": 0.25,
      "metallicRoughnessTexture": {"index": 1}},
    "normalTexture": {"index": 2, "scale": -0.5}, "occlusionTexture": {"index": 1},
    "emissiveFactor": [1, 0.5, 0], "emissiveTexture": {"index": 0},
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}})");
  EXPECT_TRUE(loaded.warnings.empty());
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.name, "x");
  EXPECT_EQ(m.reflectance.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(picture(loaded, m.reflectance.texture), "p0.png");
  EXPECT_EQ(m.opacity, FloatParam{1.0f});  // alpha is not asked for
  EXPECT_EQ(m.metallic, (FloatParam{0.5f, m.metallic.texture, 2}));
  EXPECT_EQ(m.roughness, (FloatParam{0.25f, m.metallic.texture, 1}));
  EXPECT_EQ(picture(loaded, m.metallic.texture), "p1.png");
  EXPECT_EQ(picture(loaded, m.normal_map), "p2.png");
  EXPECT_EQ(m.normal_scale, -0.5f);
  EXPECT_EQ(m.emission.value, (Rgb{8, 4, 0}));
  EXPECT_EQ(m.emission.texture, m.reflectance.texture);
  EXPECT_TRUE(m.emission_two_sided);
  const auto& textures = loaded.scene.textures;
  EXPECT_EQ(textures.size(), 3u);
  EXPECT_TRUE(textures[m.reflectance.texture.value].srgb);
  EXPECT_FALSE(textures[m.metallic.texture.value].srgb);
  EXPECT_FALSE(textures[m.normal_map.value].srgb);
}

TEST(GltfMaterial, Alpha) {
  const test::SceneFolder folder;
  const auto with = [&folder](const std::string& fields) {
    return load_with(folder, R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.4],
      "baseColorTexture": {"index": 0}}, )" +
                                 fields + "}");
  };
  const LoadedScene blend = with(R"("alphaMode": "BLEND")");
  const TextureId base = material_of(blend).reflectance.texture;
  EXPECT_EQ(material_of(blend).opacity, (FloatParam{0.4f, base, 3}));
  EXPECT_EQ(material_of(blend).alpha_cutoff, 0);
  const LoadedScene mask = with(R"("alphaMode": "MASK", "alphaCutoff": 0.3)");
  EXPECT_EQ(material_of(mask).opacity, (FloatParam{0.4f, base, 3}));
  EXPECT_EQ(material_of(mask).alpha_cutoff, 0.3f);
  EXPECT_EQ(material_of(with(R"("alphaMode": "MASK")")).alpha_cutoff, 0.5f);
  EXPECT_EQ(material_of(with(R"("alphaMode": "MASK", "alphaCutoff": 0)")).opacity,
            FloatParam{1.0f});
  EXPECT_EQ(material_of(with(R"("alphaMode": "MASK", "alphaCutoff": 2)")).opacity,
            FloatParam{0.0f});
}

TEST(GltfMaterial, Layers) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"extensions": {
    "KHR_materials_ior": {"ior": 1.33},
    "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 0},
      "specularColorFactor": [2, 1, 0], "specularColorTexture": {"index": 1}},
    "KHR_materials_clearcoat": {"clearcoatFactor": 0.25, "clearcoatTexture": {"index": 2},
      "clearcoatRoughnessFactor": 0.75, "clearcoatRoughnessTexture": {"index": 2}}}})");
  EXPECT_TRUE(loaded.warnings.empty());
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.ior, 1.33f);
  EXPECT_EQ(m.specular_weight, (FloatParam{0.5f, m.specular_weight.texture, 3}));
  EXPECT_EQ(picture(loaded, m.specular_weight.texture), "p0.png");
  EXPECT_EQ(m.specular.value, (Rgb{2, 1, 0}));
  EXPECT_TRUE(loaded.scene.textures[m.specular.texture.value].srgb);
  EXPECT_EQ(m.clearcoat, (FloatParam{0.25f, m.clearcoat.texture, 0}));
  EXPECT_EQ(m.clearcoat_roughness, (FloatParam{0.75f, m.clearcoat.texture, 1}));
}

TEST(GltfMaterial, AnIndexOfZeroReflectsAll) {
  const test::SceneFolder folder;
  const LoadedScene loaded =
      load_with(folder, R"({"extensions": {"KHR_materials_ior": {"ior": 0}}})");
  const Material& m = material_of(loaded);
  EXPECT_FLOAT_EQ(m.specular.value.r * std::pow((m.ior - 1) / (m.ior + 1), 2.0f), 1);
}

TEST(GltfMaterial, TransmissionIsThinUnlessItHasAVolume) {
  const test::SceneFolder folder;
  const auto with = [&folder](const std::string& volume) {
    return load_with(folder, R"({"extensions": {"KHR_materials_transmission": {
      "transmissionFactor": 0.5, "transmissionTexture": {"index": 0}})" +
                                 volume + "}}");
  };
  const LoadedScene thin = with("");
  EXPECT_TRUE(material_of(thin).thin);
  EXPECT_EQ(material_of(thin).transmission,
            (FloatParam{0.5f, material_of(thin).transmission.texture, 0}));
  EXPECT_EQ(picture(thin, material_of(thin).transmission.texture), "p0.png");
  const std::string absorbing =
      R"("attenuationDistance": 0.5, "attenuationColor": [1, 0.5, 0.25]})";
  const LoadedScene still_thin =
      with(R"(, "KHR_materials_volume": {"thicknessFactor": 0, )" + absorbing);
  EXPECT_TRUE(material_of(still_thin).thin);
  const LoadedScene solid =
      with(R"(, "KHR_materials_volume": {"thicknessFactor": 1, )" + absorbing);
  EXPECT_FALSE(material_of(solid).thin);
  EXPECT_EQ(material_of(solid).absorption.r, 0);
  EXPECT_FLOAT_EQ(material_of(solid).absorption.g, std::log(2.0f) / 0.5f);
  EXPECT_FLOAT_EQ(material_of(solid).absorption.b, std::log(4.0f) / 0.5f);
  EXPECT_EQ(material_of(with(R"(, "KHR_materials_volume": {"thicknessFactor": 1})")).absorption,
            Rgb{});
}

TEST(GltfMaterial, UnlitShinesInItsColorAndIsBlack) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"extensions": {"KHR_materials_unlit": {}},
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.5],
      "baseColorTexture": {"index": 0}}, "alphaMode": "BLEND", "emissiveFactor": [1, 1, 1]})");
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.kind, MaterialKind::kDiffuse);
  EXPECT_EQ(m.reflectance, (ColorParam{Rgb{0.0f}, {}}));
  EXPECT_EQ(m.emission.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(picture(loaded, m.emission.texture), "p0.png");
  EXPECT_TRUE(m.emission_two_sided);
  EXPECT_EQ(m.opacity, (FloatParam{0.5f, m.emission.texture, 3}));
}

TEST(GltfMaterial, SpecularGlossinessKeepsF0AndTurnsGlossIntoRoughness) {
  const test::SceneFolder folder;
  Image gloss(2, 1, 4);
  for (int x = 0; x < 2; ++x) {
    gloss.set_rgb(x, 0, Rgb{0.5f});
    gloss.at(x, 0, 3) = x == 0 ? 1.0f : 0.25f;
  }
  const Result<Bytes> exr = encode_image(ImageFormat::kExr, gloss);
  ASSERT_TRUE(exr.ok());
  GltfText text = gltf_triangle();
  text.json["images"] = {{{"bufferView", text.add_view(exr.value())}}};
  text.json["textures"] = {{{"source", 0}}};
  text.json["materials"] = {json::parse(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
    "diffuseFactor": [0.2, 0.3, 0.4, 1], "specularFactor": [1, 0.5, 0.04],
    "glossinessFactor": 0.8, "specularGlossinessTexture": {"index": 0}}}})")};
  const LoadedScene loaded = load_gltf(folder, text);
  EXPECT_TRUE(loaded.warnings.empty());
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.metallic.value, 0);
  EXPECT_EQ(m.reflectance.value, (Rgb{0.2f, 0.3f, 0.4f}));
  EXPECT_FLOAT_EQ(0.04f * m.specular.value.r, 1);
  EXPECT_FLOAT_EQ(0.04f * m.specular.value.g, 0.5f);
  EXPECT_FLOAT_EQ(0.04f * m.specular.value.b, 0.04f);
  EXPECT_EQ(m.roughness.value, 1);
  TextureCache cache;
  const Result<int> roughness = cache.open(loaded.scene.textures[m.roughness.texture.value]);
  ASSERT_TRUE(roughness.ok()) << roughness.error().text();
  EXPECT_NEAR(cache.lookup(roughness.value(), Vec2{0.25f, 0.5f}).r, 1 - 0.8f, 1e-5f);
  EXPECT_NEAR(cache.lookup(roughness.value(), Vec2{0.75f, 0.5f}).r, 1 - 0.2f, 1e-5f);
}

TEST(GltfMaterial, SpecularGlossinessLeavesTheDiffusePartWhatItsGreatestChannelDoes) {
  const auto diffuse = [](const char* specular) {
    const test::SceneFolder folder;
    GltfText text = gltf_triangle();
    text.json["materials"] = {json::parse(
        R"({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.2, 0.4, 0.8, 1])" +
        std::string(specular) + "}}}")};
    return material_of(load_gltf(folder, text)).reflectance.value;
  };
  EXPECT_EQ(diffuse(""), Rgb{0.0f});  // white: nothing is diffuse
  const Rgb half = diffuse(R"(, "specularFactor": [0, 0.5, 0.25])");
  EXPECT_FLOAT_EQ(half.r, 0.1f);
  EXPECT_FLOAT_EQ(half.g, 0.2f);
  EXPECT_FLOAT_EQ(half.b, 0.4f);
}

TEST(GltfMaterial, TexturesHaveTheirSamplersAndTransforms) {
  const test::SceneFolder folder;
  folder.write("p.png", "not read here");
  GltfText text = gltf_triangle();
  text.json["images"] = {{{"uri", "p.png"}}};
  text.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  text.json["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 0}}};
  text.json["materials"] = {json::parse(R"({
    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    "emissiveTexture": {"index": 1, "extensions": {"KHR_texture_transform":
      {"offset": [0, 1], "rotation": 1.5707963, "scale": [0.5, 0.5]}}},
    "emissiveFactor": [1, 1, 1]})")};
  const LoadedScene loaded = load_gltf(folder, text);
  const Texture& base = loaded.scene.textures[material_of(loaded).reflectance.texture.value];
  EXPECT_EQ(base.wrap_u, TextureWrap::kClamp);
  EXPECT_EQ(base.wrap_v, TextureWrap::kMirror);
  EXPECT_TRUE(base.nearest);
  EXPECT_EQ(base.uv_transform, UvTransform{});
  // The extension's own example: "only the lower left quadrant of the source image, rotated
  // clockwise 90 degrees". Ours is upward: the quadrant is u and v below a half.
  const Texture& turned = loaded.scene.textures[material_of(loaded).emission.texture.value];
  EXPECT_EQ(turned.wrap_u, TextureWrap::kRepeat);
  EXPECT_FALSE(turned.nearest);
  const std::pair<Vec2, Vec2> corners[] = {
      {{0, 1}, {0, 0}}, {{1, 1}, {0, 0.5f}}, {{1, 0}, {0.5f, 0.5f}}, {{0, 0}, {0.5f, 0}}};
  for (const auto& [from, to] : corners) {
    EXPECT_NEAR(turned.uv_transform(from).x, to.x, 1e-6f);
    EXPECT_NEAR(turned.uv_transform(from).y, to.y, 1e-6f);
  }
}

TEST(GltfMaterial, PicturesInsideTheFileKeepTheirBytes) {
  const test::SceneFolder folder;
  const Bytes bytes = {1, 2, 3, 4, 5};
  GltfText text = gltf_triangle();
  text.json["images"] = {{{"bufferView", text.add_view(bytes)}},
                         {{"uri", "data:image/png;base64," + test::base64(bytes)}}};
  text.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
  text.json["materials"] = {json::parse(R"({"pbrMetallicRoughness": {
    "baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}})")};
  const LoadedScene loaded = load_gltf(folder, text);
  ASSERT_EQ(loaded.scene.textures.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(loaded.scene.textures[i].bytes);
    EXPECT_EQ(*loaded.scene.textures[i].bytes, bytes);
    EXPECT_EQ(loaded.scene.textures[i].path, "a.gltf:/images/" + std::to_string(i));
  }
}

TEST(GltfMaterial, Anisotropy) {
  const test::SceneFolder folder;
  const LoadedScene plain = load_with(folder, R"({"extensions": {"KHR_materials_anisotropy": {
    "anisotropyStrength": 0.6, "anisotropyRotation": 7}}})");
  EXPECT_EQ(material_of(plain).anisotropy.value, 0.6f);
  EXPECT_NEAR(material_of(plain).anisotropy_rad, 7 - 2 * kPi, 1e-5f);
  EXPECT_EQ(plain.warnings, std::vector<std::string>{});
  const LoadedScene textured = load_with(folder, R"({"extensions": {"KHR_materials_anisotropy": {
    "anisotropyStrength": 0.6, "anisotropyTexture": {"index": 1}}}})");
  EXPECT_EQ(picture(textured, material_of(textured).anisotropy.texture), "p1.png");
  EXPECT_EQ(material_of(textured).anisotropy.channel, 2);
  EXPECT_TRUE(material_of(textured).anisotropy_directions);
  EXPECT_FALSE(material_of(plain).anisotropy_directions);
  EXPECT_TRUE(textured.warnings.empty());
}

TEST(GltfMaterial, DiffuseTransmissionAndIridescence) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"extensions": {
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.6,
      "diffuseTransmissionTexture": {"index": 0},
      "diffuseTransmissionColorFactor": [0.1, 0.2, 0.3],
      "diffuseTransmissionColorTexture": {"index": 1}},
    "KHR_materials_iridescence": {"iridescenceFactor": 0.7, "iridescenceTexture": {"index": 2},
      "iridescenceIor": 1.8, "iridescenceThicknessMinimum": 50, "iridescenceThicknessMaximum": 900,
      "iridescenceThicknessTexture": {"index": 2}}}})");
  EXPECT_TRUE(loaded.warnings.empty());
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.diffuse_transmission, (FloatParam{0.6f, m.diffuse_transmission.texture, 3}));
  EXPECT_EQ(m.diffuse_transmission_color.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_TRUE(loaded.scene.textures[m.diffuse_transmission_color.texture.value].srgb);
  EXPECT_EQ(m.iridescence, (FloatParam{0.7f, m.film_nm.texture, 0}));
  EXPECT_EQ(m.film_nm, (FloatParam{900, m.film_nm.texture, 1}));
  EXPECT_EQ(picture(loaded, m.film_nm.texture), "p2.png");
  EXPECT_EQ(m.film_least_nm, 50);
  EXPECT_EQ(m.film_ior, 1.8f);
  const LoadedScene plain =
      load_with(folder, R"({"extensions": {"KHR_materials_iridescence": {}}})");
  EXPECT_EQ(material_of(plain).iridescence.value, 0);
  EXPECT_EQ(material_of(plain).film_nm.value, 400);
  EXPECT_EQ(material_of(plain).film_ior, 1.3f);
}

TEST(GltfMaterial, ACoatHasNormalsOfItsOwn) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"normalTexture": {"index": 0}, "extensions": {
    "KHR_materials_clearcoat": {"clearcoatFactor": 1,
      "clearcoatNormalTexture": {"index": 1, "scale": 0.5}}}})");
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_TRUE(material_of(loaded).own_coat_normal);
  EXPECT_EQ(picture(loaded, material_of(loaded).coat_normal_map), "p1.png");
  EXPECT_EQ(material_of(loaded).coat_normal_scale, 0.5f);
  const LoadedScene plain = load_with(folder, R"({"normalTexture": {"index": 0}, "extensions": {
    "KHR_materials_clearcoat": {"clearcoatFactor": 1}}})");
  EXPECT_TRUE(material_of(plain).own_coat_normal);
  EXPECT_FALSE(material_of(plain).coat_normal_map.valid());
}

TEST(GltfMaterial, WhatIsNotReadIsAWarning) {
  const test::SceneFolder folder;
  const std::string at = "a.gltf:/materials/0/extensions/";
  for (const auto& [name, strength] :
       {std::pair<std::string, std::string>{"KHR_materials_dispersion", "dispersion"}}) {
    const auto warnings = [&](const std::string& members) {
      return load_with(folder, R"({"extensions": {")" + name + "\": {" + members + "}}}").warnings;
    };
    EXPECT_EQ(warnings("\"" + strength + "\": 0.5"),
              std::vector<std::string>{at + name + ": the extension " + name + " is left out"});
    EXPECT_EQ(warnings("\"" + strength + "\": 0"), std::vector<std::string>{});
    EXPECT_EQ(warnings(""), std::vector<std::string>{});
  }
  EXPECT_EQ(load_with(folder, R"({"extensions": {"KHR_materials_ior": {"ior": 5}}})").warnings,
            std::vector<std::string>{
                at + "KHR_materials_ior/ior: an index outside 1..4 is drawn as the nearest"});

  GltfText text = gltf_triangle();
  folder.write("p.webp", "not read here");
  text.json["images"] = {{{"uri", "p.webp"}}};
  text.json["textures"] = json::parse(
      R"([{"extensions": {"KHR_texture_basisu": {"source": 0}}},
          {"extensions": {"EXT_texture_webp": {"source": 0}}}])");
  text.json["materials"] = {json::parse(R"({"normalTexture": {"index": 0},
    "emissiveTexture": {"index": 1}})")};
  const LoadedScene loaded = load_gltf(folder, text);
  EXPECT_FALSE(material_of(loaded).normal_map.valid());
  EXPECT_EQ(picture(loaded, material_of(loaded).emission.texture), "p.webp");
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{"a.gltf:/textures/0/extensions/KHR_texture_basisu: the "
                                     "extension KHR_texture_basisu is left out"});
}

TEST(GltfMaterial, Sheen) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_with(folder, R"({"extensions": {"KHR_materials_sheen": {
    "sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": {"index": 0},
    "sheenRoughnessFactor": 0.4, "sheenRoughnessTexture": {"index": 1}}}})");
  const Material& m = material_of(loaded);
  EXPECT_EQ(m.sheen.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(picture(loaded, m.sheen.texture), "p0.png");
  EXPECT_TRUE(loaded.scene.textures[m.sheen.texture.value].srgb);
  EXPECT_EQ(m.sheen_roughness.value, 0.4f);
  EXPECT_EQ(m.sheen_roughness.channel, 3);
  EXPECT_EQ(picture(loaded, m.sheen_roughness.texture), "p1.png");
  EXPECT_TRUE(loaded.warnings.empty());
}

TEST(GltfMaterial, FaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}})",
       "/pbrMetallicRoughness/baseColorFactor: expected an array of 4 numbers, got an array of 3"},
      {R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 2, 1, 1]}})",
       "/pbrMetallicRoughness/baseColorFactor/1: expected 0..1, got 2"},
      {R"({"pbrMetallicRoughness": {"roughnessFactor": -0.5}})",
       "/pbrMetallicRoughness/roughnessFactor: expected 0..1, got -0.5"},
      {R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}})",
       "/pbrMetallicRoughness/baseColorTexture/index: expected an integer, 0..0, got 1"},
      {R"({"pbrMetallicRoughness": {"baseColorTexture": {}}})",
       "/pbrMetallicRoughness/baseColorTexture: \"index\" is missing"},
      {R"({"pbrMetallicRoughness": []})", "/pbrMetallicRoughness: expected an object"},
      {R"({"emissiveFactor": [1, 1, "1"]})", "/emissiveFactor/2: expected a number, got \"1\""},
      {R"({"alphaMode": "GLASS"})", "/alphaMode: expected OPAQUE, MASK or BLEND, got \"GLASS\""},
      {R"({"doubleSided": 1})", "/doubleSided: expected true or false, got 1"},
      {R"({"extensions": {"KHR_materials_volume": {"thicknessFactor": 1,
           "attenuationDistance": 0}}})",
       "/extensions/KHR_materials_volume/attenuationDistance: expected 1e-09..inf, got 0"},
      {R"({"normalTexture": {"index": 0, "extensions": {"KHR_texture_transform":
           {"scale": [1]}}}})",
       "/normalTexture/extensions/KHR_texture_transform/scale: expected an array of 2 numbers"},
  };
  for (const auto& [material, failure] : cases) {
    GltfText text = gltf_triangle();
    folder.write("p.png", "not read here");
    text.json["images"] = {{{"uri", "p.png"}}};
    text.json["textures"] = {{{"source", 0}}};
    text.json["materials"] = {json::parse(material)};
    const std::string got = folder.failure("a.gltf", text.gltf());
    EXPECT_TRUE(got.starts_with(std::string("a.gltf:/materials/0") + failure)) << got;
  }
}

}  // namespace
}  // namespace qray
