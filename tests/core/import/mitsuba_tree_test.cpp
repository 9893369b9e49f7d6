#include "core/import/mitsuba_tree.h"

#include <gtest/gtest.h>

#include "core/import/mitsuba_values.h"
#include "tests/core/import/mitsuba_text.h"
#include "tests/support/near.h"

namespace qray {
namespace {

using test::expect_near;
using test::kMitsubaRectangle;
using test::kMitsubaSensor;
using test::mitsuba_scene;

MitsubaDocument read(const test::SceneFolder& folder, const std::string& text) {
  return read_mitsuba_tree(folder.write("scene.xml", text));
}

TEST(MitsubaTree, NamesAreSnakeCase) {
  const std::pair<const char*, const char*> cases[] = {
      {"toWorld", "to_world"},     {"to_world", "to_world"},
      {"intIOR", "int_ior"},       {"alphaU", "alpha_u"},
      {"filename", "filename"},    {"specularReflectance", "specular_reflectance"},
      {"wrapModeU", "wrap_mode_u"}};
  for (const auto& [from, to] : cases) EXPECT_EQ(to_snake_case(from), to);
}

TEST(MitsubaTree, ParametersAreTheLongestNameThatFitsAndTheFirstValue) {
  const test::SceneFolder folder;
  const MitsubaDocument document =
      read(folder,
           "<scene><default name=\"res\" value=\"1\"/><default name=\"resx\" value=\"2\"/>"
           "<default name=\"res\" value=\"3\"/><default name=\"both\" value=\"$res-$resx\"/>"
           "<string name=\"a\" value=\"$resx $res.png $both $other\"/></scene>");
  EXPECT_EQ(document.root.children.at(0).need("value"), "2 1.png 1-2 $other");
}

TEST(MitsubaTree, IncludesShareParametersAndIds) {
  const test::SceneFolder folder;
  std::filesystem::create_directory(folder.path() / "parts");
  folder.write("parts/inner.xml",
               "<scene version=\"0.6.0\"><default name=\"v\" value=\"inner\"/>\n"
               "<string name=\"s\" value=\"$v\" id=\"there\"/></scene>");
  const MitsubaDocument document =
      read(folder,
           "<scene version=\"3.0.0\"><default name=\"v\" value=\"outer\"/>\n"
           "<include filename=\"parts/inner.xml\"/>\n<ref id=\"there\"/></scene>");
  EXPECT_EQ(document.version, 3);
  ASSERT_EQ(document.root.children.size(), 2u);
  const MitsubaNode& included = document.resolve(document.root.children[1]);
  EXPECT_EQ(included.need("value"), "outer");
  EXPECT_EQ(included.where, "parts/inner.xml:2");
}

TEST(MitsubaTree, FaultsNameFileAndLine) {
  const test::SceneFolder folder;
  folder.write("loop.xml", "<scene>\n<include filename=\"loop.xml\"/></scene>");
  folder.write("a.xml", "<scene><include filename=\"b.xml\"/></scene>");
  folder.write("b.xml", "<scene>\n\n<include filename=\"a.xml\"/></scene>");
  folder.write("broken.xml", "<scene>\n<shape>\n</scene>");
  std::ofstream(folder.path().parent_path() / "outside.xml") << "<scene/>";
  const struct {
    std::string text, where;
  } cases[] = {
      {"<scene>\n<shape type=\"cube\">\n</scene>", "scene.xml:3"},
      {"", "scene.xml:1"},
      {"<bsdf/>", "scene.xml:1: expected <scene>, got <bsdf>"},
      {"<scene>\n<include filename=\"loop.xml\"/></scene>",
       "loop.xml:2: \"loop.xml\" includes itself"},
      {"<scene>\n<include filename=\"a.xml\"/></scene>", "b.xml:3: \"a.xml\" includes itself"},
      {"<scene>\n<include filename=\"scene.xml\"/></scene>", "scene.xml:2"},
      {"<scene>\n\n<include filename=\"broken.xml\"/></scene>", "broken.xml:3"},
      {"<scene>\n<include filename=\"gone.xml\"/></scene>",
       "scene.xml:2: no such file in the scene's folder: \"gone.xml\""},
      {"<scene>\n<include filename=\"../outside.xml\"/></scene>",
       "scene.xml:2: no such file in the scene's folder: \"../outside.xml\""},
      {"<scene>\n<include filename=\"/etc/hostname\"/></scene>", "scene.xml:2"},
      {"<scene>\n<include/></scene>", "scene.xml:2: expected an attribute \"filename\""},
      {"<scene>\n<bsdf id=\"a\"/>\n<bsdf id=\"a\"/></scene>",
       "scene.xml:3: the id \"a\" is taken by the element at scene.xml:2"},
      {"<scene>\n<default name=\"x\"/></scene>", "scene.xml:2: expected an attribute \"value\""},
      {"<scene>\n<default value=\"x\"/></scene>", "scene.xml:2: expected a \"name\""},
      {"<scene>\n<alias id=\"no\" as=\"b\"/></scene>", "scene.xml:2: no element has the id \"no\""},
      {"<scene>\n<path value=\"..\"/></scene>", "scene.xml:2: expected a folder within"},
  };
  for (const auto& c : cases) {
    const std::string failure = folder.failure("scene.xml", c.text);
    EXPECT_TRUE(failure.starts_with(c.where)) << c.text << "\n-> " << failure;
  }
}

TEST(MitsubaTree, BombsAreRefused) {
  const test::SceneFolder folder;
  std::string deep = "<scene>";
  for (int i = 0; i < 100; ++i) deep += "<bsdf>";
  for (int i = 0; i < 100; ++i) deep += "</bsdf>";
  EXPECT_NE(folder.failure("scene.xml", deep + "</scene>").find("at most 64 levels"),
            std::string::npos);
  // Each parameter ten of the one before.
  std::string laughs = "<scene>\n<default name=\"x0\" value=\"" + std::string(1000, 'h') + "\"/>";
  for (int i = 1; i < 9; ++i) {
    laughs += "<default name=\"x" + std::to_string(i) + "\" value=\"";
    for (int k = 0; k < 10; ++k) laughs += "$x" + std::to_string(i - 1);
    laughs += "\"/>";
  }
  EXPECT_EQ(folder.failure("scene.xml", laughs + "</scene>"),
            "scene.xml:2: the parameters put in grow too large");
  // Files that include each other without a cycle: 2^20 of them.
  for (int i = 0; i < 15; ++i) {
    const std::string next = "<include filename=\"f" + std::to_string(i + 1) + ".xml\"/>";
    folder.write("f" + std::to_string(i) + ".xml", "<scene>" + next + next + "</scene>");
  }
  folder.write("f15.xml", "<scene/>");
  const std::string failure =
      folder.failure("scene.xml", "<scene><include filename=\"f1.xml\"/></scene>");
  EXPECT_NE(failure.find("expected at most 256 files"), std::string::npos) << failure;
}

Vec3 moved(const Transform& t, Vec3 p) {
  Mesh mesh;
  mesh.positions = {p};
  t.apply(mesh);
  return mesh.positions[0];
}

Transform transform_of(const std::string& steps) {
  const test::SceneFolder folder;
  const MitsubaDocument document = read(folder, "<scene><shape><transform name=\"toWorld\">" +
                                                    steps + "</transform></shape></scene>");
  return *find_transform(document.root.children.at(0), "to_world");
}

TEST(MitsubaValues, TransformsComposeInTheirOrder) {
  expect_near(moved(transform_of("<scale value=\"2\"/><translate x=\"1\"/>"), {1, 1, 1}),
              {3, 2, 2});
  expect_near(moved(transform_of("<translate x=\"1\"/><scale x=\"2\" y=\"3\"/>"), {1, 1, 1}),
              {4, 3, 1});
  expect_near(moved(transform_of("<translate value=\"1, 2,3\"/>"), {0, 0, 0}), {1, 2, 3});
  // Counter-clockwise seen from the axis' tip.
  expect_near(moved(transform_of("<rotate z=\"1\" angle=\"90\"/>"), {1, 0, 0}), {0, 1, 0});
  expect_near(
      moved(transform_of("<matrix value=\"0 0 1 5, 0 1 0 6 1e-000 0 0 7 0 0 0 1\"/>"), {1, 2, 3}),
      {8, 8, 8});
  expect_near(moved(transform_of("<matrix value=\"0 -1 0 1 0 0 0 0 1\"/>"), {1, 0, 0}), {0, 1, 0});
}

TEST(MitsubaValues, LookAtHasTheViewAsItsZ) {
  for (const char* tag : {"lookat", "lookAt", "look_at"}) {
    const Transform t = transform_of(std::string("<") + tag +
                                     " origin=\"1 2 3\" target=\"1, 2, 13\" up=\"0 1 0\"/>");
    expect_near(moved(t, {0, 0, 0}), {1, 2, 3});
    expect_near(moved(t, {0, 0, 4}), {1, 2, 7});
    expect_near(moved(t, {0, 1, 0}), {1, 3, 3});
    expect_near(moved(t, {1, 0, 0}), {2, 2, 3});
    EXPECT_NEAR(t.determinant(), 1, 1e-6);
  }
}

}  // namespace
}  // namespace qray
