#include "core/import/obj.h"

#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "core/import/polygon.h"
#include "tests/core/import/scene_text.h"
#include "tests/support/places.h"

namespace qray {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(Obj, NamesTheLineOfEveryFault) {
  const struct {
    std::string text;
    const char* error;
  } cases[] = {
      {"v 0 0\n", "a.obj:1: expected 3 numbers, got 2"},
      {"v 0 0 0\nv 1 zero 0\n", "a.obj:2: expected a number, got \"zero\""},
      {"v 0 0 nan\n", "a.obj:1: expected a number, got \"nan\""},
      {"v 0 0 1e99\n", "a.obj:1: expected a number, got \"1e99\""},
      {"# nothing\nvn 0 1\n", "a.obj:2: expected 3 numbers, got 2"},
      {kTriangle + "f\n", "a.obj:4: expected at least 3 corners, got 0"},
      {kTriangle + "f 1 \\\n2 3\nf 1 2 4\n",
       "a.obj:6: expected the index of one of the 3 positions so far, got 4"},
      {kTriangle + "f 1 2 4\n",
       "a.obj:4: expected the index of one of the 3 positions so far, got 4"},
      {kTriangle + "f 1 2 -4\n",
       "a.obj:4: expected the index of one of the 3 positions so far, got -4"},
      {kTriangle + "f 0 1 2\n",
       "a.obj:4: expected the index of one of the 3 positions so far, got 0"},
      {kTriangle + "f 1/1 2/1 3/1\n",
       "a.obj:4: expected the index of one of the 0 texture coordinates so far, got 1"},
      {kTriangle + "f 1//1 2//1 3//1\n",
       "a.obj:4: expected the index of one of the 0 normals so far, got 1"},
      {kTriangle + "\r\nf 1 2 x\r\n", "a.obj:5: expected a corner like 1/2/3, got \"x\""},
      {"v 0 0 0\rv 1 0 0\rf 3 2 3\n",
       "a.obj:3: expected the index of one of the 2 positions so far, got 3"},
      {kTriangle + "f 1 2 3/\n", "a.obj:4: expected a corner like 1/2/3, got \"3/\""},
      {kTriangle + "f 1 2 3/1/1/1\n",
       "a.obj:4: expected the index of one of the 0 texture coordinates so far, got 1"},
      {kTriangle + "f 1 2 99999999999999999999\n", "a.obj:4: expected a corner like 1/2/3"},
      {kTriangle, "a.obj: expected at least one face"},
      {"", "a.obj: expected at least one face"},
  };
  const test::SceneFolder folder;
  for (const auto& c : cases) {
    const std::string failure = folder.failure("a.obj", c.text);
    EXPECT_EQ(failure.substr(0, std::string_view(c.error).size()), c.error) << c.text;
  }
}

TEST(Obj, AHugePolygonIsRefused) {
  std::string text = kTriangle + "f";
  for (int i = 0; i < 2000; ++i) text += " 1 2 3";
  const test::SceneFolder folder;
  EXPECT_EQ(folder.failure("a.obj", text), "a.obj:4: expected at most 1024 corners, got 6000");
}

TEST(Obj, TriangulatesPolygonsAndSharesCorners) {
  const test::SceneFolder folder;
  const ObjContents contents =
      read_obj(folder.write("a.obj",
                            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                            "vn 0 0 2\nf -4/1/1 -3/2/1 -2/3/1 -1/4/1\n"),
               {});
  ASSERT_EQ(contents.meshes.size(), 1u);
  const Mesh& mesh = contents.meshes[0];
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.positions.size(), 4u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(test::front(mesh, i), (Vec3{0, 0, 1}));
  for (const Vec3 n : mesh.normals) EXPECT_EQ(n, (Vec3{0, 0, 1}));
  for (size_t i = 0; i < 4; ++i)
    EXPECT_EQ((Vec2{mesh.positions[i].x, mesh.positions[i].y}), mesh.uvs[i]);
}

// A comb of many teeth, in each of the axes' planes, drawn either way round: of the same area as
// cut.
TEST(Obj, ConcavePolygonsKeepTheirShape) {
  std::vector<Vec2> comb = {{0, 0}};
  constexpr int kTeeth = 20;
  for (int i = 0; i < kTeeth; ++i) {
    const auto x = static_cast<float>(i);
    comb.insert(comb.end(), {{x + 0.5f, -3}, {x + 1, 0}});
  }
  comb.insert(comb.end(), {{kTeeth, 1}, {0, 1}});
  constexpr float kArea = kTeeth * (1 + 1.5f);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool reversed : {false, true}) {
      std::vector<Vec3> corners;
      for (const Vec2& p : comb) {
        Vec3& corner = corners.emplace_back();
        corner[(axis + 1) % 3] = p.x, corner[(axis + 2) % 3] = p.y;
      }
      if (reversed) std::reverse(corners.begin(), corners.end());
      Vec3 sum;
      float size = 0;
      for (const auto& [a, b, c] : cut_polygon(corners)) {
        const Vec3 twice = cross(corners[b] - corners[a], corners[c] - corners[a]);
        sum = sum + twice * 0.5f;
        size += length(twice) * 0.5f;
      }
      EXPECT_NEAR(sum[axis], reversed ? -kArea : kArea, 1e-4f) << axis;
      EXPECT_NEAR(size, kArea, 1e-4f) << "no triangle lies over another";
    }
}

TEST(Obj, AMeshWithoutAllItsNormalsIsFlat) {
  const test::SceneFolder folder;
  const ObjContents missing =
      read_obj(folder.write("a.obj", kTriangle + "vn 0 0 1\nf 1//1 2//1 3\n"), {});
  EXPECT_TRUE(missing.meshes[0].normals.empty());
  const ObjContents zero =
      read_obj(folder.write("a.obj", kTriangle + "vn 0 0 0\nf 1//1 2//1 3//1\n"), {});
  EXPECT_TRUE(zero.meshes[0].normals.empty());
}

TEST(Obj, ConvertsMaterials) {
  const test::SceneFolder folder;
  folder.write("wood.png", "not opened here");
  folder.write("m.mtl", R"(newmtl diffuse
Kd 0.1 0.2 0.3
newmtl shiny
Kd 0.5 0.5 0.5
Ks 0.04 0.02 0.01
Ns 198
Ni 1.5
illum 2
newmtl mirror
Kd 0 0 0
Ks 0.9 0.8 0.7
illum 5
newmtl glass
Ni 1.7
illum 7
newmtl faint
d 0.2
Ni 1.0
newmtl lamp
Ke 17 12 4
newmtl wood
Kd 0 0 0
map_Kd wood.png
newmtl bright
Kd 1.5 0.5 0.5
map_Kd gone.png
)");
  std::string text = "mtllib m.mtl\n" + kTriangle;
  for (const char* name :
       {"diffuse", "shiny", "mirror", "glass", "faint", "lamp", "wood", "bright"})
    text += std::string("usemtl ") + name + "\nf 1 2 3\n";
  const auto loaded = folder.load("a.obj", text);
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& s = loaded.value().scene;
  ASSERT_EQ(s.meshes.size(), 8u);
  const auto material = [&s](size_t i) -> const Material& {
    return s.materials[s.meshes[i].material.value];
  };
  EXPECT_EQ(material(0).kind, MaterialKind::kDiffuse);
  EXPECT_EQ(material(0).reflectance.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(material(1).kind, MaterialKind::kPlastic);
  EXPECT_NEAR(material(1).specular.value.r, 1, 1e-5f);  // 0.04 is what glass of 1.5 reflects
  EXPECT_NEAR(material(1).specular.value.g, 0.5f, 1e-5f);
  EXPECT_NEAR(sqr(sqr(material(1).roughness.value)), 0.01f, 1e-5f);  // alpha^2 = 2 / (Ns + 2)
  EXPECT_EQ(material(2).kind, MaterialKind::kConductor);
  EXPECT_EQ(material(2).specular.value, (Rgb{0.9f, 0.8f, 0.7f}));
  EXPECT_EQ(material(2).roughness.value, 0);
  EXPECT_EQ(material(3).kind, MaterialKind::kDielectric);
  EXPECT_EQ(material(3).ior, 1.7f);
  EXPECT_EQ(material(4).kind, MaterialKind::kDielectric);
  EXPECT_EQ(material(4).ior, 1.5f);
  EXPECT_EQ(material(5).emission.value, (Rgb{17, 12, 4}));
  EXPECT_EQ(material(6).reflectance, (ColorParam{Rgb{1}, TextureId(0)}));
  EXPECT_EQ(s.textures[0].path, folder.path() / "wood.png");
  EXPECT_EQ(material(7).reflectance, (ColorParam{{1, 0.5f, 0.5f}, {}}));
  ASSERT_EQ(loaded.value().warnings.size(), 2u);
  EXPECT_NE(loaded.value().warnings[0].find("\"bright\": Kd"), std::string::npos);
  EXPECT_NE(loaded.value().warnings[1].find("gone.png"), std::string::npos);
}

TEST(Obj, LinesMayGoOn) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n2 \\\n3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.meshes.at(0).triangles.size(), 1u);
}

TEST(Obj, PointsAndEdgesAreLeftOutWithOneWarning) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.obj", kTriangle + "l 1 2\np 1\nl 2 3\nf 1 2\nf 1 2 3\nf 3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.meshes.at(0).triangles.size(), 1u);
  EXPECT_EQ(loaded.value().warnings,
            (std::vector<std::string>{
                "a.obj:4: points and lines are left out, here and elsewhere",
                "a.obj:7: faces of fewer than 3 corners are left out, here and elsewhere"}));
}

TEST(Obj, ColorsOfVertices) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.obj",
                                  "v 0 0 0 1 0 0.5\nv 1 0 0 0 0 0\nv 0 1 0\nv 0 2 0 1\nv 1 2 0\n"
                                  "f 1 2 3\no plain\nf 3 4 5\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Mesh& mesh = loaded.value().scene.meshes.at(0);
  ASSERT_EQ(mesh.colors.size(), 3u);
  EXPECT_NEAR(mesh.colors[0].b, 0.2140f, 1e-4f);  // display-encoded
  EXPECT_EQ(mesh.colors[1], Rgb{0.0f});
  EXPECT_EQ(mesh.colors[2], Rgb{1.0f});
  EXPECT_TRUE(loaded.value().scene.meshes.at(1).colors.empty());
}

TEST(Obj, PhysicalMaterialsAndTheirPictures) {
  const test::SceneFolder folder;
  ASSERT_TRUE(write_image(folder.path() / "rgb.png", Image(2, 2, 3)).ok());
  ASSERT_TRUE(write_image(folder.path() / "rgba.png", Image(2, 2, 4)).ok());
  folder.write("m.mtl", R"(newmtl pbr
Kd 0.5 0.25 0.125
Pr 0.3
Pm 0.75
map_Pr rgb.png
map_Kd -s 2 3 1 -o 0.5 0.25 0 rgb.png
norm rgb.png
newmtl leaf
map_d rgba.png
newmtl net
map_d rgb.png
map_Ke rgb.png
map_bump rgb.png
)");
  const auto loaded = folder.load("a.obj", "mtllib m.mtl\n" + kTriangle +
                                               "usemtl pbr\nf 1 2 3\nusemtl leaf\nf 1 2 3\n"
                                               "usemtl net\nf 1 2 3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& scene = loaded.value().scene;
  const Material &pbr = scene.materials.at(0), &leaf = scene.materials.at(1),
                 &net = scene.materials.at(2);
  EXPECT_EQ(pbr.kind, MaterialKind::kPrincipled);
  EXPECT_EQ(pbr.reflectance.value, (Rgb{0.5f, 0.25f, 0.125f}));
  EXPECT_EQ(pbr.metallic, (FloatParam{0.75f}));
  EXPECT_EQ(pbr.roughness.value, 0.3f);
  ASSERT_TRUE(pbr.roughness.texture.valid() && pbr.normal_map.valid());
  EXPECT_FALSE(scene.textures[pbr.roughness.texture.value].srgb);
  const Texture& color = scene.textures[pbr.reflectance.texture.value];
  EXPECT_TRUE(color.srgb);
  EXPECT_EQ(color.uv_transform({1, 1}).x, 2.5f);
  EXPECT_EQ(color.uv_transform({1, 1}).y, 3.25f);
  EXPECT_EQ(leaf.opacity.channel, 3);
  EXPECT_EQ(net.opacity.channel, kLuminance);
  EXPECT_EQ(net.emission.value, Rgb{1.0f});
  EXPECT_EQ(loaded.value().warnings,
            (std::vector<std::string>{"material \"net\": map_bump is left out"}));
}

TEST(Obj, NamesMayHaveSpacesAndBackslashes) {
  const test::SceneFolder folder;
  folder.write("in/my file.mtl", "newmtl dark red\r\nKd 0.5 0 0\r\nnewmtl b\r\nKd 0 0 1\r\n");
  folder.write("c.mtl", "newmtl c\nKd 0 1 0\n");
  const auto loaded =
      folder.load("a.obj", "mtllib .\\in\\my file.mtl\r\nmtllib c.mtl in/my\n" + kTriangle +
                               "usemtl dark red \r\nf 1 2 3\n"
                               "usemtl b or another\nf 1 2 3\n"
                               "usemtl c\nf 1 2 3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& scene = loaded.value().scene;
  ASSERT_EQ(scene.meshes.size(), 3u);
  const auto color = [&](size_t mesh) {
    return scene.materials[scene.meshes[mesh].material.value].reflectance.value;
  };
  EXPECT_EQ(color(0), (Rgb{0.5f, 0, 0}));
  EXPECT_EQ(color(1), (Rgb{0, 0, 1}));
  EXPECT_EQ(color(2), (Rgb{0, 1, 0}));
}

TEST(Obj, AMissingLibraryIsAWarningAndGrey) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.obj", "mtllib gone.mtl\n" + kTriangle + "usemtl x\nf 1 2 3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  ASSERT_FALSE(loaded.value().warnings.empty());
  EXPECT_EQ(loaded.value().warnings[0].substr(0, 9), "gone.mtl:");
  EXPECT_EQ(loaded.value().scene.meshes[0].material, MaterialId(0));
}

TEST(Obj, FilesOutsideOfItsFolderAreNotRead) {
  const test::SceneFolder folder;
  folder.write("a.mtl", "newmtl red\nKd 1 0 0\n");
  folder.write("t.png", "");
  folder.write("in/b.mtl", "newmtl b\nKd 1 0 0\nmap_Kd ../t.png\n");
  const ObjContents contents = read_obj(
      folder.write("in/a.obj", "mtllib ../a.mtl\nmtllib b.mtl\n" + kTriangle + "f 1 2 3\n"), {});
  EXPECT_TRUE(contents.textures.empty());
  ASSERT_EQ(contents.warnings.size(), 2u);
  EXPECT_EQ(contents.warnings[0],
            "../a.mtl: no such file in the scene's folder: \"../a.mtl\"; its materials are grey");
  EXPECT_NE(contents.warnings[1].find("no such file in the scene's folder: \"../t.png\""),
            std::string::npos)
      << contents.warnings[1];
}

TEST(Obj, PublicDomainCornellBoxesLoad) {
  const std::filesystem::path folder = test::testdata_dir() / "obj-cornell-dev";
  if (!std::filesystem::is_directory(folder))
    GTEST_SKIP() << "no test data: " << folder << " is not there";
  const struct {
    const char* name;
    size_t triangles;
  } cases[] = {{"CornellBox-Original.obj", 36},
               {"CornellBox-Mirror.obj", 36},
               {"CornellBox-Sphere.obj", 2188},
               {"CornellBox-Empty-RG.obj", 12}};
  for (const auto& c : cases) {
    const auto loaded = load_scene(folder / c.name);
    ASSERT_TRUE(loaded.ok()) << loaded.error().text();
    const Scene& s = loaded.value().scene;
    EXPECT_EQ(s.triangle_count(), c.triangles) << c.name;
    EXPECT_FALSE(s.environment.present()) << c.name;
    int lamps = 0;
    for (const Mesh& mesh : s.meshes) {
      if (!s.materials[mesh.material.value].emits()) continue;
      ++lamps;
      EXPECT_LT(test::front(mesh, 0).y, -0.99f) << c.name;  // shines down
    }
    EXPECT_EQ(lamps, 1) << c.name;
    // Open at +z: seen from outside, along the axis.
    EXPECT_GT(s.camera.position.z, s.bounds().hi.z + 1) << c.name;
    EXPECT_NEAR(s.camera.position.x, s.bounds().center().x, 1e-4f) << c.name;
  }
}

}  // namespace
}  // namespace qray
