#include "core/import/mitsuba_material.h"

#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/core/import/mitsuba_text.h"
#include "tests/support/near.h"

namespace qray {
namespace {

using test::expect_near;
using test::mitsuba_bsdf;

class MitsubaMaterial : public testing::Test {
 protected:
  LoadedScene load(const std::string& text) {
    auto loaded = folder_.load("scene.xml", text);
    EXPECT_TRUE(loaded.ok()) << loaded.error().text();
    return loaded.ok() ? std::move(loaded).value() : LoadedScene{};
  }
  Material of(const std::string& bsdf, const std::string& version = "0.6.0") {
    loaded_ = load(mitsuba_bsdf(bsdf, version));
    return loaded_.scene.materials.at(loaded_.scene.meshes.at(0).material.value);
  }
  // Of something in the file, not that nothing emits.
  bool warned() const {
    return std::any_of(loaded_.warnings.begin(), loaded_.warnings.end(),
                       [](const std::string& w) { return w.starts_with("scene.xml:3: "); });
  }

  test::SceneFolder folder_;
  LoadedScene loaded_;
};

TEST_F(MitsubaMaterial, ColoursInEverySpelling) {
  const auto reflectance = [&](const std::string& color, const char* version = "0.6.0") {
    return of("<bsdf type=\"diffuse\">" + color + "</bsdf>", version).reflectance.value;
  };
  EXPECT_EQ(reflectance(""), Rgb{0.5f});
  EXPECT_EQ(reflectance("<rgb name=\"reflectance\" value=\"0.1 0.2,0.3\"/>"), (Rgb{.1f, .2f, .3f}));
  EXPECT_EQ(reflectance("<rgb name=\"reflectance\" value=\"#ff0033\"/>"), (Rgb{1, 0, 0.2f}));
  EXPECT_EQ(reflectance("<spectrum name=\"reflectance\" value=\"0.25\"/>"), Rgb{0.25f});
  EXPECT_EQ(reflectance("<float name=\"reflectance\" value=\"0.25\"/>", "3.0.0"), Rgb{0.25f});
  expect_near(reflectance("<srgb name=\"reflectance\" value=\"0.5\"/>"), Rgb{0.21404f}, 1e-4f);
  EXPECT_FALSE(warned());
  EXPECT_EQ(reflectance("<rgb name=\"reflectance\" value=\"2\"/>"), Rgb{1.0f});
  EXPECT_TRUE(warned());
  // A flat list: Mitsuba 0.x sees it under equal energy, 3 under D65.
  const std::string list = "<spectrum name=\"reflectance\" value=\"300:0.5, 900:0.5\"/>";
  expect_near(reflectance(list), Rgb{1.2048f, 0.9483f, 0.9088f} * 0.5f, 1e-3f);
  expect_near(reflectance(list, "3.0.0"), Rgb{0.5f}, 1e-3f);
  folder_.write("flat.spd", "# a comment\n300 0.5\n900 0.5 # another\n\n");
  expect_near(reflectance("<spectrum name=\"reflectance\" filename=\"flat.spd\"/>", "2.1.0"),
              Rgb{0.5f}, 1e-3f);
}

TEST_F(MitsubaMaterial, SidesAreAsInMitsuba) {
  EXPECT_FALSE(of("").two_sided);
  EXPECT_FALSE(of("<bsdf type=\"diffuse\"/>").two_sided);
  EXPECT_TRUE(of("<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>").two_sided);
  EXPECT_TRUE(
      of("<bsdf type=\"mask\"><bsdf type=\"twosided\"><bsdf type=\"plastic\"/></bsdf></bsdf>")
          .two_sided);
}

TEST_F(MitsubaMaterial, AlphaIsRoughnessSquared) {
  const Material m =
      of("<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.25\"/>"
         "<string name=\"distribution\" value=\"ggx\"/></bsdf>");
  EXPECT_EQ(m.roughness.value, 0.5f);
  EXPECT_EQ(m.microfacets, Microfacets::kGgx);
  EXPECT_EQ(of("<bsdf type=\"roughplastic\"/>").microfacets, Microfacets::kBeckmann);
  EXPECT_FALSE(warned());
  of("<bsdf type=\"roughdielectric\"><string name=\"distribution\" value=\"phong\"/></bsdf>");
  EXPECT_TRUE(warned());
  const Material two =
      of("<bsdf type=\"roughconductor\"><float name=\"alphaU\" value=\"0.1\"/>"
         "<float name=\"alphaV\" value=\"0.4\"/></bsdf>");
  EXPECT_FALSE(warned());
  EXPECT_NEAR(sqr(two.roughness.value), 0.1f, 1e-6f);
  EXPECT_NEAR(0.1f + sqr(two.anisotropy.value) * 0.9f, 0.4f, 1e-6f);  // along v
  EXPECT_NEAR(two.anisotropy_rad, kPi / 2, 1e-6f);
  EXPECT_FALSE(of("<bsdf type=\"roughconductor\"><float name=\"alphaU\" value=\"1\"/>"
                  "<float name=\"alphaV\" value=\"1\"/></bsdf>")
                   .anisotropic());
}

TEST_F(MitsubaMaterial, DisneysAnisotropyStretchesAlongU) {
  const Material m =
      of("<bsdf type=\"principled\"><float name=\"roughness\" value=\"0.5\"/>"
         "<float name=\"anisotropic\" value=\"0.8\"/></bsdf>",
         "3.0.0");
  const float aspect = std::sqrt(1 - 0.72f), least = 0.25f * aspect;
  EXPECT_FALSE(warned());
  EXPECT_NEAR(sqr(m.roughness.value), least, 1e-6f);
  EXPECT_NEAR(least + sqr(m.anisotropy.value) * (1 - least), 0.25f / aspect, 1e-6f);
  EXPECT_EQ(m.anisotropy_rad, 0);
}

TEST_F(MitsubaMaterial, MetalsByNameAndByNumber) {
  // Mitsuba 0.x: copper in air.
  const Material copper = of("<bsdf type=\"conductor\"/>");
  expect_near(copper.eta, Rgb{0.200438f, 0.924033f, 1.10221f} * (1 / 1.000277f), 1e-5f);
  expect_near(copper.k, Rgb{3.91295f, 2.45285f, 2.14219f} * (1 / 1.000277f), 1e-5f);
  for (const char* version : {"0.6.0", "3.0.0"}) {
    const Material mirror =
        of("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>", version);
    EXPECT_EQ(mirror.eta, Rgb{0.0f});
    EXPECT_EQ(mirror.k, Rgb{1.0f});
  }
  const Material given =
      of("<bsdf type=\"conductor\"><rgb name=\"eta\" value=\"1 2 3\"/>"
         "<rgb name=\"k\" value=\"4 5 6\"/><float name=\"extEta\" value=\"2\"/></bsdf>");
  EXPECT_EQ(given.eta, (Rgb{0.5f, 1, 1.5f}));
  EXPECT_EQ(given.k, (Rgb{2, 2.5f, 3}));
  of("<bsdf type=\"conductor\"><string name=\"material\" value=\"Unobtainium\"/></bsdf>");
  EXPECT_TRUE(warned());
  // As a well-known room is distributed.
  const Material negative =
      of("<bsdf type=\"conductor\"><rgb name=\"eta\" value=\"1, -0.25, 2\"/>"
         "<spectrum name=\"k\" value=\"3 4 5\"/></bsdf>",
         "3.0.0");
  EXPECT_EQ(negative.eta, (Rgb{1, 0, 2}));
  EXPECT_EQ(negative.k, (Rgb{3, 4, 5}));
  EXPECT_TRUE(warned());
}

TEST_F(MitsubaMaterial, GlassByNameAndInsideOut) {
  EXPECT_NEAR(of("<bsdf type=\"dielectric\"/>").ior, 1.5046f / 1.000277f, 1e-5f);
  EXPECT_NEAR(of("<bsdf type=\"thindielectric\"><string name=\"intIOR\" value=\"water\"/>"
                 "<float name=\"ext_ior\" value=\"1\"/></bsdf>")
                  .ior,
              1.333f, 1e-5f);
  const std::string water_in_glass =
      "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.2\"/>"
      "<float name=\"extIOR\" value=\"1.5\"/></bsdf>";
  EXPECT_NEAR(of(water_in_glass).ior, 1.25f, 1e-5f);
  EXPECT_EQ(test::front(loaded_.scene.meshes[0], 0), (Vec3{0, 0, -1}));
}

TEST_F(MitsubaMaterial, GlassHasAColourForWhatItReflectsAndOneForWhatItPasses) {
  for (const std::string type : {"dielectric", "roughdielectric", "thindielectric"}) {
    const Material black = of("<bsdf type=\"" + type +
                              "\"><spectrum name=\"specularTransmittance\" value=\"0\"/></bsdf>");
    EXPECT_EQ(black.specular.value, Rgb{1.0f}) << type;
    EXPECT_EQ(black.transmittance.value, Rgb{0.0f}) << type;
    const Material plain = of("<bsdf type=\"" + type +
                              "\"><rgb name=\"specularReflectance\" value=\"0 0.5 1\"/></bsdf>");
    EXPECT_EQ(plain.specular.value, (Rgb{0, 0.5f, 1})) << type;
    EXPECT_EQ(plain.transmittance.value, Rgb{1.0f}) << type;
    EXPECT_FALSE(warned()) << type;
  }
}

TEST_F(MitsubaMaterial, WhatSaysNothingIsNoWarning) {
  const auto warnings = [&](const std::string& parameters) {
    of("<bsdf type=\"principled\">" + parameters + "</bsdf>", "3.0.0");
    return warned();
  };
  EXPECT_FALSE(
      warnings("<float name=\"anisotropic\" value=\"0.0\"/>"
               "<rgb name=\"sheen\" value=\"0, 0, 0\"/>"
               "<float name=\"sheenTint\" value=\"0.5\"/>"
               "<float name=\"specTint\" value=\"0\"/>"
               "<float name=\"flatness\" value=\"0\"/>"));
  EXPECT_FALSE(warnings("<float name=\"sheen_tint\" value=\"1\"/>"));
  EXPECT_TRUE(warnings("<float name=\"flatness\" value=\"1\"/>"));
}

TEST_F(MitsubaMaterial, PlasticIsLinearUnlessAsked) {
  const Material m = of("<bsdf type=\"plastic\"/>");
  EXPECT_EQ(m.kind, MaterialKind::kPlastic);
  EXPECT_NEAR(m.ior, 1.49f / 1.000277f, 1e-5f);
  EXPECT_FALSE(m.nonlinear);
  EXPECT_TRUE(of("<bsdf type=\"roughplastic\"><boolean name=\"nonlinear\" value=\"true\"/></bsdf>")
                  .nonlinear);
}

TEST_F(MitsubaMaterial, BlendsKeepTheOrder) {
  const Material m =
      of("<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/>"
         "<bsdf type=\"diffuse\"/><bsdf type=\"conductor\"/></bsdf>");
  ASSERT_EQ(m.kind, MaterialKind::kBlend);
  EXPECT_EQ(m.blend_weight.value, 0.25f);  // of the second
  EXPECT_EQ(loaded_.scene.materials.at(m.first.value).kind, MaterialKind::kDiffuse);
  EXPECT_EQ(loaded_.scene.materials.at(m.second.value).kind, MaterialKind::kConductor);
}

// The shares of a blend add up to the reflectances: kd + ks.
TEST_F(MitsubaMaterial, PhongReflectsBothItsParts) {
  const Material m =
      of("<bsdf type=\"phong\"><rgb name=\"diffuseReflectance\" value=\"0.3\"/>"
         "<rgb name=\"specularReflectance\" value=\"0.6\"/></bsdf>");
  EXPECT_TRUE(warned());
  ASSERT_EQ(m.kind, MaterialKind::kBlend);
  const Material& base = loaded_.scene.materials.at(m.first.value);
  const Material& gloss = loaded_.scene.materials.at(m.second.value);
  const float w = m.blend_weight.value;
  EXPECT_NEAR((1 - w) * base.reflectance.value.r, 0.3f, 1e-5f);
  EXPECT_NEAR(w * gloss.specular.value.r, 0.6f, 1e-5f);
}

TEST_F(MitsubaMaterial, AnAbsorbingMediumFillsGlass) {
  const Material m =
      of("<bsdf type=\"dielectric\"/><medium type=\"homogeneous\" name=\"interior\">"
         "<rgb name=\"sigmaA\" value=\"0.5 0.2 0.4\"/><rgb name=\"sigmaS\" value=\"0\"/>"
         "<float name=\"scale\" value=\"2\"/></medium>");
  EXPECT_EQ(m.absorption, (Rgb{1, 0.4f, 0.8f}));
  EXPECT_FALSE(warned());
}

TEST_F(MitsubaMaterial, ACheckerboardIsAPictureOfFourTexels) {
  const Material m =
      of("<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"checkerboard\">"
         "<rgb name=\"color0\" value=\"0.8\"/><rgb name=\"color1\" value=\"0.1 0.2 0.3\"/>"
         "<float name=\"uscale\" value=\"20\"/><float name=\"voffset\" value=\"0.25\"/>"
         "</texture></bsdf>");
  ASSERT_TRUE(m.reflectance.texture.valid());
  const Texture& texture = loaded_.scene.textures.at(m.reflectance.texture.value);
  EXPECT_TRUE(texture.nearest);
  EXPECT_FALSE(texture.srgb);
  ASSERT_TRUE(texture.bytes);
  const auto file = folder_.write(
      "board.exr", std::string_view(reinterpret_cast<const char*>(texture.bytes->data()),
                                    texture.bytes->size()));
  const Image image = read_image(file).value();
  ASSERT_EQ(image.width(), 2);
  expect_near(image.rgb(0, 0), Rgb{0.8f}, 1e-6f);  // Mitsuba's uv (0, 0) is the top left
  expect_near(image.rgb(1, 0), {0.1f, 0.2f, 0.3f}, 1e-6f);
  expect_near(image.rgb(1, 1), Rgb{0.8f}, 1e-6f);
  // v = 1, Mitsuba's 0, is looked up 0.25 further down.
  const Vec2 uv = texture.uv_transform({0.1f, 1});
  EXPECT_NEAR(uv.x, 2, 1e-5f);
  EXPECT_NEAR(uv.y, 0.75f, 1e-5f);
}

TEST_F(MitsubaMaterial, PrincipledIsDisneys) {
  const auto principled = [&](const std::string& parameters) {
    return of("<bsdf type=\"principled\"><rgb name=\"base_color\" value=\"0.5 0.5 0\"/>" +
                  parameters + "</bsdf>",
              "3.0.0");
  };
  const auto number = [](const char* name, const char* value) {
    return "<float name=\"" + std::string(name) + "\" value=\"" + value + "\"/>";
  };
  const Material plain = principled(number("spec_trans", "0.5"));
  EXPECT_TRUE(plain.disney);
  expect_near(plain.reflectance.value, {0.5f, 0.5f, 0}, 1e-6f);  // the root is the renderer's
  expect_near(plain.specular.value, Rgb{1.0f}, 1e-6f);
  const float hue = 1 / luminance(Rgb{1, 1, 0});
  const Material tinted =
      principled(number("spec_tint", "0.5") + number("sheen", "0.8") + number("sheen_tint", "1"));
  expect_near(tinted.specular.value, {0.5f + 0.5f * hue, 0.5f + 0.5f * hue, 0.5f}, 1e-5f);
  expect_near(tinted.sheen.value, {0.8f * hue, 0.8f * hue, 0}, 1e-5f);
  EXPECT_FALSE(warned());
  principled(number("flatness", "1"));
  EXPECT_TRUE(warned());
}

TEST_F(MitsubaMaterial, PicturesAreNumbersByTheirLuminance) {
  ASSERT_TRUE(write_image(folder_.path() / "rgb.png", Image(2, 2, 3)).ok());
  ASSERT_TRUE(write_image(folder_.path() / "rgba.png", Image(2, 2, 4)).ok());
  const auto picture = [](const std::string& name, const std::string& file) {
    return "<texture name=\"" + name + "\" type=\"bitmap\"><string name=\"filename\" value=\"" +
           file + "\"/></texture>";
  };
  const std::string diffuse = "<bsdf type=\"diffuse\"/>";
  const auto mask = [&](const std::string& file) {
    return of("<bsdf type=\"mask\">" + picture("opacity", file) + diffuse + "</bsdf>").opacity;
  };
  EXPECT_EQ(mask("rgb.png").channel, kLuminance);
  EXPECT_EQ(mask("rgba.png").channel, 3);
  EXPECT_EQ(
      of("<bsdf type=\"blendbsdf\">" + picture("weight", "rgb.png") + diffuse + diffuse + "</bsdf>")
          .blend_weight.channel,
      kLuminance);
}

TEST_F(MitsubaMaterial, BitmapsAreReadAsTheyAsk) {
  ASSERT_TRUE(write_image(folder_.path() / "a b.png", Image(2, 2, 3)).ok());
  const auto texture = [&](const std::string& parameters) {
    const Material m =
        of("<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"bitmap\">"
           "<string name=\"filename\" value=\"a b.png\"/>" +
           parameters + "</texture></bsdf>");
    return loaded_.scene.textures.at(m.reflectance.texture.value);
  };
  EXPECT_TRUE(texture("").srgb);
  EXPECT_FALSE(texture("<float name=\"gamma\" value=\"1\"/>").srgb);
  EXPECT_FALSE(texture("<boolean name=\"raw\" value=\"true\"/>").srgb);
  EXPECT_TRUE(texture("<string name=\"filterType\" value=\"nearest\"/>").nearest);
  EXPECT_EQ(texture("<string name=\"wrapModeU\" value=\"mirror\"/>").wrap_u, TextureWrap::kMirror);
  EXPECT_EQ(texture("<string name=\"wrap_mode\" value=\"clamp\"/>").wrap_v, TextureWrap::kClamp);
  EXPECT_FALSE(warned());
  // Turned by 90 degrees: u' = -v_m, v_m' = u.
  const UvTransform turned =
      texture("<transform name=\"to_uv\"><rotate z=\"1\" angle=\"90\"/></transform>").uv_transform;
  EXPECT_NEAR(turned({0.25f, 0.75f}).x, -0.25f, 1e-6f);
  EXPECT_NEAR(turned({0.25f, 0.75f}).y, 0.75f, 1e-6f);
}

}  // namespace
}  // namespace qray
