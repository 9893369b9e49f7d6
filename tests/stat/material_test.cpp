// What materials do to a picture, against closed forms: light that passes, is absorbed, is picked
// from images; and the same mean whichever way light is found.
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/support/near.h"
#include "tests/support/render.h"
#include "tests/support/scratch.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr int kSide = 16;
constexpr int kPictures = 12;

test::Moments brightness(const PreparedScene& scene, bool nee = true, int samples = 64,
                         const std::string& method = "none") {
  test::Moments mean;
  for (uint64_t seed = 1; seed <= kPictures; ++seed) {
    RenderSettings settings = test::small_settings(method, kSide, samples, seed);
    settings.nee = nee;
    mean.add(test::mean_luminance(test::render(scene, settings).image));
  }
  return mean;
}
void expect_mean(const test::Moments& measured, double expected, int tests, const char* what) {
  EXPECT_GT(test::z_test(measured, expected, 1e-4 * expected).p_value, test::significance(tests))
      << what << ": " << measured.mean() << " +- " << measured.standard_error() << ", expected "
      << expected;
}
void expect_same(const test::Moments& a, const test::Moments& b, int tests, const char* what) {
  EXPECT_GT(test::z_test(a, b).p_value, test::significance(tests))
      << what << ": " << a.mean() << " +- " << a.standard_error() << " against " << b.mean()
      << " +- " << b.standard_error();
}

MaterialId add(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return MaterialId(static_cast<uint32_t>(scene.materials.size() - 1));
}
TextureId add_texture(Scene& scene, const test::ScratchFolder& folder, const Image& image) {
  static int count = 0;
  Texture texture;
  texture.path = folder / ("t" + std::to_string(count++) + ".exr");
  texture.srgb = false;
  texture.nearest = true;
  EXPECT_TRUE(write_image(texture.path, image).ok());
  scene.textures.push_back(texture);
  return TextureId(static_cast<uint32_t>(scene.textures.size() - 1));
}
// A square about the axis at height y, its front up or down, with uv in [0, 1].
void add_sheet(Scene& scene, MaterialId material, float y, float half, bool up) {
  test::add_quad(scene, material, {-half, y, -half}, {2 * half, 0, 0}, {0, 0, 2 * half});
  scene.meshes.back().uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  if (up)
    for (auto& tri : scene.meshes.back().triangles) std::swap(tri[1], tri[2]);
}
// The camera looks straight up at a wall that shines with radiance 1, and sees nothing else.
Scene wall_above() {
  Scene scene;
  add_sheet(scene, test::add_material(scene, {}, Rgb{1.0f}), 10, 20, /*up=*/false);
  scene.camera.position = {0, 0, 0};
  scene.camera.target = {0, 1, 0};
  scene.camera.up = {0, 0, 1};
  scene.camera.vertical_fov_deg = 20;
  return scene;
}
// A gray floor seen from the side, a small lamp above, and between them a black sheet of a given
// opacity that the camera does not see.
Scene floor_under_a_sheet(const Material& sheet, float lamp_radiance = 100) {
  Scene scene;
  add_sheet(scene, test::add_material(scene, Rgb{0.5f}), 0, 0.5f, /*up=*/true);
  add_sheet(scene, test::add_material(scene, {}, Rgb{lamp_radiance}), 2, 0.25f, false);
  add_sheet(scene, add(scene, sheet), 1.5f, 20, true);
  scene.camera.position = {0, 1, 1};
  scene.camera.target = {0, 0, 0};
  scene.camera.vertical_fov_deg = 25;
  return scene;
}
Material black(float opacity) {
  Material m;
  m.reflectance.value = {};
  m.opacity.value = opacity;
  return m;
}
Image checks(Rgb a, Rgb b) {
  Image image(8, 8, 3);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) image.set_rgb(x, y, (x + y) % 2 == 0 ? a : b);
  return image;
}

TEST(Material, WhatIsNotOpaqueLetsItsShareOfCameraRaysPass) {
  for (const float opacity : {0.0f, 0.3f, 0.9f, 1.0f}) {
    Scene scene = wall_above();
    add_sheet(scene, add(scene, black(opacity)), 5, 10, false);
    add_sheet(scene, add(scene, black(opacity)), 6, 10, true);
    const double passed = 1 - static_cast<double>(opacity);
    expect_mean(brightness(*test::prepare(scene)), passed * passed, 8, "two sheets");
  }
}

// docs/scenes.md has the distances at which the second is skipped.
TEST(Material, BothOfTwoPanesAFifthOfAMillimetreApartAreMet) {
  Material pane;
  pane.kind = MaterialKind::kThinDielectric;
  pane.ior = 1;
  pane.transmittance.value = Rgb{0.5f};
  Scene scene = wall_above();
  add_sheet(scene, add(scene, pane), 5, 10, false);
  add_sheet(scene, add(scene, pane), 5.0002f, 10, false);
  expect_mean(brightness(*test::prepare(scene)), 0.25, 8, "two panes");
}

TEST(Material, ShadowRaysAndBouncesPassAlike) {
  const test::Moments free = brightness(*test::prepare(floor_under_a_sheet(black(0))));
  EXPECT_GT(free.mean(), 0.1);
  for (const float opacity : {0.25f, 0.7f}) {
    const auto scene = test::prepare(floor_under_a_sheet(black(opacity)));
    // Scaled to what the sheet leaves, all must agree.
    const auto scaled = [&](const test::Moments& m) {
      return m.mean() / (1 - static_cast<double>(opacity));
    };
    for (const bool nee : {true, false}) {
      const test::Moments seen = brightness(*scene, nee, nee ? 64 : 512);
      const double error = std::hypot(seen.standard_error() / (1 - static_cast<double>(opacity)),
                                      free.standard_error());
      EXPECT_NEAR(scaled(seen), free.mean(), 4 * error) << opacity << (nee ? " nee" : "");
      EXPECT_LT(error, 0.02 * free.mean());
    }
  }
}

TEST(Material, AnImagesChannelIsCutOff) {
  // Green is 0.8 in half of the squares and 0.4 in the rest; the other channels say nothing.
  const test::ScratchFolder folder;
  const auto passed = [&](float cutoff) {
    Scene scene = wall_above();
    Material m = black(1);
    m.opacity.texture = add_texture(scene, folder, checks({1, 0.8f, 0}, {1, 0.4f, 0}));
    m.opacity.channel = 1;
    m.alpha_cutoff = cutoff;
    add_sheet(scene, add(scene, m), 5, 0.9f, false);  // fills the picture
    return brightness(*test::prepare(scene)).mean();
  };
  EXPECT_NEAR(passed(0), 0.4, 0.01);
  EXPECT_NEAR(passed(0.6f), 0.5, 0.03);
  EXPECT_NEAR(passed(0.3f), 0, 1e-6);
  EXPECT_NEAR(passed(0.9f), 1, 1e-6);
}

TEST(Material, GuidedMethodsKeepTheMeanWithMasksAndBlends) {
  Scene scene = test::room();
  Material veil;
  veil.reflectance.value = {0.2f, 0.7f, 0.4f};
  veil.opacity.value = 0.4f;
  Material metal;
  metal.kind = MaterialKind::kConductor;
  metal.roughness.value = 0.3f;
  Material mixed;
  mixed.kind = MaterialKind::kBlend;
  mixed.first = add(scene, veil);
  mixed.second = add(scene, metal);
  mixed.blend_weight.value = 0.4f;
  const MaterialId mixed_id = add(scene, mixed);
  test::add_quad(scene, mixed_id, {-0.9f, 0.3f, -0.7f}, {1.8f, 0, 0}, {0, 1.5f, 0});
  const auto prepared = test::prepare(scene);
  const test::Moments none = brightness(*prepared);
  for (const std::string method : {"adaptive", "ppg", "huang"})
    expect_same(brightness(*prepared, true, 64, method), none, 3, method.c_str());
  expect_same(brightness(*prepared, false, 256), none, 3, "without nee");
}

TEST(Material, ABlendScattersAsItsShares) {
  // Under a white sky a convex surface shows its albedo.
  Scene scene;
  Material dark, bright, blend;
  dark.reflectance.value = Rgb{0.2f};
  bright.reflectance.value = Rgb{0.8f};
  blend.kind = MaterialKind::kBlend;
  blend.first = add(scene, dark);
  blend.second = add(scene, bright);
  blend.blend_weight.value = 0.75f;
  Material outer = blend;
  outer.first = add(scene, blend);
  outer.second = MaterialId(0);
  outer.blend_weight.value = 0.5f;
  add_sheet(scene, add(scene, outer), 5, 50, false);
  scene.environment.radiance = Rgb{1.0f};
  scene.camera = wall_above().camera;
  for (const bool nee : {true, false})
    expect_mean(brightness(*test::prepare(scene), nee), 0.5 * (0.65 + 0.2), 2, "blend");
}

TEST(Material, AMaskedBlendMeetsWhatIsOpaqueMoreOften) {
  // Of half 0.2 at opacity 1 and half 0.8 at opacity 0.5: a quarter passes to a wall of 1.
  Scene scene = wall_above();
  Material solid, veil, blend;
  solid.reflectance.value = Rgb{0.2f};
  veil.reflectance.value = Rgb{0.8f};
  veil.opacity.value = 0.5f;
  blend.kind = MaterialKind::kBlend;
  blend.first = add(scene, solid);
  blend.second = add(scene, veil);
  add_sheet(scene, add(scene, blend), 5, 50, false);
  scene.environment.radiance = Rgb{1.0f};  // lights the sheet from below
  expect_mean(brightness(*test::prepare(scene)), 0.5 * 0.2 + 0.25 * 0.8 + 0.25, 1, "masked blend");
}

TEST(Material, APanePassesWhatItDoesNotReflect) {
  Scene scene = wall_above();
  Material pane;
  pane.kind = MaterialKind::kThinDielectric;
  pane.ior = 2;
  add_sheet(scene, add(scene, pane), 5, 10, false);
  scene.camera.vertical_fov_deg = 1;
  const double one_face = 1.0 / 9;
  expect_mean(brightness(*test::prepare(scene)), 1 - 2 * one_face / (1 + one_face), 1, "pane");
}

TEST(Material, GlassAbsorbsByTheWayThroughIt) {
  // Index 1: straight on, nothing reflected. 2 metres of it, then a mirror inside sends no ray
  // back.
  for (const MaterialKind kind : {MaterialKind::kDielectric, MaterialKind::kPrincipled}) {
    Scene scene = wall_above();
    Material glass;
    glass.kind = kind;
    glass.ior = 1;
    glass.reflectance.value = Rgb{1.0f};
    glass.transmission.value = 1;
    glass.specular_weight.value = 0;
    glass.absorption = {0, 0.25f, 1};
    test::add_box(scene, add(scene, glass), {-5, 2, -5}, {5, 4, 5}, false);
    scene.camera.vertical_fov_deg = 1;
    const Image image =
        test::render(*test::prepare(scene), test::small_settings("none", 4, 16)).image;
    const Rgb seen = image.rgb(2, 2);
    EXPECT_NEAR(seen.r, 1, 1e-3);
    EXPECT_NEAR(seen.g, std::exp(-0.5), 1e-3);
    EXPECT_NEAR(seen.b, std::exp(-2), 1e-3);
  }
}

// Radiance in glass of index 2 is four times as much, and throughput a quarter.
TEST(Material, RouletteTakesGlassForTheOpen) {
  Scene scene = wall_above();
  Material glass;
  glass.kind = MaterialKind::kDielectric;
  glass.ior = 2;
  const MaterialId id = add(scene, glass);
  for (int i = 0; i < 6; ++i) {
    const float y = 2 + static_cast<float>(i);
    test::add_box(scene, id, {-20, y, -20}, {20, y + 0.5f, 20}, false);
  }
  scene.camera.vertical_fov_deg = 1;
  RenderSettings settings = test::small_settings("none", 8, 64);
  settings.max_depth = 32;
  const auto prepared = test::prepare(scene);
  const auto with = static_cast<double>(test::render(*prepared, settings).job.stats.rays);
  settings.russian_roulette = false;
  const auto without = static_cast<double>(test::render(*prepared, settings).job.stats.rays);
  EXPECT_GT(with / without, 0.7);  // .52 where throughput decides as it is
}

TEST(Material, LightWithinAbsorbingGlassIsFoundAlike) {
  // A lamp and a gray floor in a tinted block: nee inside it, and rays that leave through rough
  // sides.
  Scene scene;
  Material glass;
  glass.kind = MaterialKind::kDielectric;
  glass.ior = 1.2f;
  glass.roughness.value = 0.4f;
  glass.absorption = {0.2f, 1, 2};
  test::add_box(scene, add(scene, glass), {-1, 0, -1}, {1, 2, 1}, false);
  add_sheet(scene, test::add_material(scene, Rgb{0.6f}), 0.1f, 0.8f, true);
  add_sheet(scene, test::add_material(scene, {}, Rgb{8.0f}), 1.8f, 0.6f, false);
  scene.camera.position = {0, 1, 4};
  scene.camera.target = {0, 0.6f, 0};
  scene.camera.vertical_fov_deg = 35;
  const auto prepared = test::prepare(scene);
  const test::Moments found = brightness(*prepared, true, 256),
                      hit = brightness(*prepared, false, 256);
  EXPECT_GT(found.mean(), 0.05);
  EXPECT_LT(hit.standard_error(), 0.03 * hit.mean());
  expect_same(found, hit, 1, "nee");
}

TEST(Material, APicturesEmissionIsFoundAlike) {
  // A lamp that shines in a quarter of its squares, behind a mask of its own.
  const test::ScratchFolder folder;
  Scene scene = floor_under_a_sheet(black(0), 60);
  Image image(2, 2, 3);
  image.set_rgb(1, 0, {1, 0.5f, 0.25f});
  Material& lamp = scene.materials[1];
  lamp.emission.texture = add_texture(scene, folder, image);
  lamp.opacity.value = 0.8f;
  const auto prepared = test::prepare(scene);
  const test::Moments found = brightness(*prepared, true, 256),
                      hit = brightness(*prepared, false, 1024);
  EXPECT_GT(found.mean(), 0.01);
  EXPECT_LT(hit.standard_error(), 0.02 * hit.mean());
  expect_same(found, hit, 1, "nee");
}

TEST(Material, OneSidedIsBlackFromBehind) {
  for (const bool two_sided : {true, false})
    for (const bool front : {true, false}) {
      Scene scene;
      Material m;
      m.two_sided = two_sided;
      add_sheet(scene, add(scene, m), 5, 50, /*up=*/!front);
      scene.environment.radiance = Rgb{1.0f};
      scene.camera = wall_above().camera;
      const double seen = brightness(*test::prepare(scene)).mean();
      EXPECT_NEAR(seen, two_sided || front ? 0.5 : 0.0, 1e-3) << two_sided << front;
    }
}

TEST(Material, TexturesReadTheUvsThatTheyAskFor) {
  const test::ScratchFolder folder;
  Image image(2, 1, 3);
  image.set_rgb(0, 0, {1, 0, 0});
  image.set_rgb(1, 0, {0, 1, 0});
  for (const bool second : {false, true}) {
    Scene scene;
    Material m = black(1);
    m.emission = {Rgb{1.0f}, add_texture(scene, folder, image)};
    m.emission_two_sided = true;
    scene.textures.back().second_uvs = second;
    add_sheet(scene, add(scene, m), 5, 50, false);
    scene.meshes.back().uvs.assign(4, {0.25f, 0.5f});
    scene.meshes.back().second_uvs.assign(4, {0.75f, 0.5f});
    scene.camera = wall_above().camera;
    const Image seen =
        test::render(*test::prepare(scene), test::small_settings("none", kSide, 1)).image;
    EXPECT_EQ(seen.rgb(1, 1), (second ? Rgb{0, 1, 0} : Rgb{1, 0, 0}));
  }
}

// A sheet in the plane y = 0 whose material `change` makes.
template <class F>
std::shared_ptr<const PreparedScene> sheet_of(const test::ScratchFolder& folder, Rgb texel,
                                              const F& change) {
  Scene scene;
  Material m;
  m.kind = MaterialKind::kPrincipled;
  change(m, add_texture(scene, folder, checks(texel, texel)));
  add_sheet(scene, add(scene, m), 0, 1, /*up=*/true);
  return test::prepare(scene);
}
const Hit kFirstTriangle{0, {}, {0, 1, 0}, MeshId(0), 0};

TEST(Material, IsBrushedAlongThePicturesDirections) {
  const test::ScratchFolder folder;
  const auto frame = [&](bool directions, float turn) {
    const auto prepared = sheet_of(folder, {0.5f, 1, 1}, [&](Material& m, TextureId texture) {
      m.anisotropy = {1, texture, 2};
      m.anisotropy_directions = directions;
      m.anisotropy_rad = turn;
    });
    return prepared->frame_at(prepared->materials[0], kFirstTriangle, {0, 1, 0}, Vec2{0.5f, 0.5f});
  };
  test::expect_near(frame(true, 0).x, frame(false, kPi / 2).x, 1e-3f);  // the picture says v
  test::expect_near(frame(true, 0.3f).x, frame(false, kPi / 2 + 0.3f).x, 1e-3f);
}

TEST(Material, ACoatHasItsOwnNormals) {
  const test::ScratchFolder folder;
  const auto normal = [&](bool mapped) {
    const auto prepared = sheet_of(folder, {0.8f, 0.5f, 0.9f}, [&](Material& m, TextureId texture) {
      m.clearcoat.value = 1;
      m.normal_map = texture;
      m.own_coat_normal = true;
      if (mapped) m.coat_normal_map = texture;
    });
    EXPECT_TRUE(prepared->materials[0].coat_bends);
    SurfacePoint surface{{}, {0, 1, 0}, {0, 1, 0}, Vec2{0.5f, 0.5f}};
    prepared->bend(prepared->materials[0], kFirstTriangle, {0, 1, 0}, surface);
    EXPECT_LT(surface.ns.y, 0.9f);
    const Vec3 coat =
        prepared->coat_normal(prepared->materials[0], kFirstTriangle, {0, 1, 0}, surface);
    return std::pair{coat, surface.ns};
  };
  test::expect_near(normal(false).first, {0, 1, 0}, 1e-5f);
  const auto [coat, base] = normal(true);
  test::expect_near(coat, base, 1e-3f);
}

// Vertex normals that a model's maker leaned far over, as beveled edges have them: what would
// mirror the eye below the surface is bent back.
TEST(Material, APrincipledMirrorOfLeaningNormalsIsNotBlack) {
  for (const float lean : {0.0f, 1.0f, 3.0f}) {
    Scene scene;
    Material m;
    m.kind = MaterialKind::kPrincipled;
    m.reflectance.value = Rgb{1.0f};
    m.metallic.value = 1;
    add_sheet(scene, add(scene, m), 0, 0.5f, /*up=*/true);
    scene.meshes.back().normals.assign(4, normalize(Vec3{0, 1, -lean}));
    scene.environment.radiance = Rgb{1.0f};
    scene.camera.position = {0, 0.4f, 1};
    scene.camera.target = {0, 0, 0};
    scene.camera.vertical_fov_deg = 15;
    EXPECT_NEAR(brightness(*test::prepare(scene)).mean(), 1, 1e-3) << lean;
  }
}

TEST(Material, ALevelNormalMapChangesNothingAndASteepOneMakesNoLight) {
  const test::ScratchFolder folder;
  const auto picture = [&](Rgb a, Rgb b, MaterialKind kind) {
    Scene scene;
    Material m;
    m.kind = kind;
    m.reflectance.value = Rgb{1.0f};
    m.roughness.value = 0.4f;
    if (!(a == Rgb{})) m.normal_map = add_texture(scene, folder, checks(a, b));
    add_sheet(scene, add(scene, m), 0, 0.5f, /*up=*/true);
    scene.environment.radiance = Rgb{1.0f};
    scene.camera.position = {0, 0.4f, 1};
    scene.camera.target = {0, 0, 0};
    scene.camera.vertical_fov_deg = 15;
    return test::render(*test::prepare(scene), test::small_settings("none", kSide, 256)).image;
  };
  for (const MaterialKind kind :
       {MaterialKind::kDiffuse, MaterialKind::kPlastic, MaterialKind::kPrincipled}) {
    const Image plain = picture({}, {}, kind);
    const Image level = picture({0.5f, 0.5f, 1}, {0.5f, 0.5f, 1}, kind);
    const Image steep = picture({0.95f, 0.5f, 0.6f}, {0.05f, 0.4f, 0.6f}, kind);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        EXPECT_NEAR(luminance(level.rgb(x, y)), luminance(plain.rgb(x, y)), 0.06);
        EXPECT_LT(luminance(steep.rgb(x, y)), 1.1);
        EXPECT_GT(luminance(steep.rgb(x, y)), 0.25) << "a black spot at " << x << ", " << y;
      }
    EXPECT_LE(test::mean_luminance(steep), 1.01);
  }
}

}  // namespace
}  // namespace qray
