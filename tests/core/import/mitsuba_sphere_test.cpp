// Mitsuba's spheres: exact where they can be, else triangles of the exact area.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/core/import/mitsuba_text.h"

namespace qray {
namespace {

Mesh first_mesh(const std::string& shapes) {
  const test::SceneFolder folder;
  const auto loaded = folder.load(
      "scene.xml", "<scene version=\"0.6.0\">" + test::kMitsubaSensor + shapes + "</scene>");
  EXPECT_TRUE(loaded.ok()) << loaded.error().text();
  return loaded.ok() ? loaded.value().scene.meshes.at(0) : Mesh{};
}

struct Case {
  const char* name;
  std::string scale;  // of toWorld; empty: none
  bool exact;
};

const std::vector<Case> kCases{{"plain", "", true},
                               {"mirrored", "<scale z=\"-1\"/>", true},
                               {"grown", "<scale value=\"2\"/>", true},
                               {"stretched", "<scale z=\"2\"/>", false}};

TEST(MitsubaSphere, IsExactUnlessItIsStretchedAndHasItsFrontWhereItShould) {
  for (const Case& c : kCases) {
    for (const bool flipped : {false, true}) {
      std::string inside;
      if (!c.scale.empty()) inside = "<transform name=\"toWorld\">" + c.scale + "</transform>";
      if (flipped) inside += "<boolean name=\"flipNormals\" value=\"true\"/>";
      const Mesh mesh = first_mesh("<shape type=\"sphere\">" + inside + "</shape>");
      ASSERT_EQ(mesh.sphere.has_value(), c.exact) << c.name;
      ASSERT_EQ(mesh.triangles.empty(), c.exact) << c.name;
      if (c.exact) {
        EXPECT_EQ(mesh.sphere->inward, flipped) << c.name;
      }
      for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const float out = dot(test::front(mesh, i), mesh.positions[mesh.triangles[i][0]]);
        EXPECT_EQ(out > 0, !flipped) << c.name << " " << i;
      }
    }
  }
}

TEST(MitsubaSphere, OfAnInstanceHasTheExactAreaInTriangles) {
  const Mesh mesh = first_mesh(
      "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"><float name=\"radius\" "
      "value=\"3\"/><point name=\"center\" x=\"10\"/></shape></shape>"
      "<shape type=\"instance\"><ref id=\"g\"/></shape>");
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 p = mesh.positions[t[0]];
    area += double{length(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p))} / 2;
  }
  EXPECT_NEAR(area / (36 * std::numbers::pi), 1, 1e-5);
}

}  // namespace
}  // namespace qray
