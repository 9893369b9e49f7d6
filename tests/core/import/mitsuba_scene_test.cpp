#include "core/import/mitsuba_scene.h"

#include <gtest/gtest.h>

#include "tests/core/import/mitsuba_text.h"

namespace qray {
namespace {

using test::kMitsubaRectangle;
using test::kMitsubaSensor;
using test::mitsuba_bsdf;
using test::mitsuba_scene;

LoadedScene load(const std::string& text, const test::SceneFolder& folder = {}) {
  auto loaded = folder.load("scene.xml", text);
  EXPECT_TRUE(loaded.ok()) << loaded.error().text();
  return loaded.ok() ? std::move(loaded).value() : LoadedScene{};
}

std::string with_sensor(const std::string& sensor) {
  return "<scene version=\"0.6.0\">" + sensor + kMitsubaRectangle + "</scene>";
}

TEST(MitsubaSensor, LooksAlongItsZ) {
  const LoadedScene loaded = load(with_sensor(
      "<sensor type=\"perspective\"><float name=\"fov\" value=\"60\"/>"
      "<transform name=\"toWorld\"><lookat origin=\"1 2 3\" target=\"1 2 -7\" up=\"0 1 0\"/>"
      "</transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/>"
      "<integer name=\"height\" value=\"100\"/></film></sensor>"));
  const Camera& camera = loaded.scene.camera;
  EXPECT_EQ(camera.position, (Vec3{1, 2, 3}));
  EXPECT_EQ(normalize(camera.target - camera.position), (Vec3{0, 0, -1}));
  EXPECT_FALSE(camera.mirrored);
  EXPECT_EQ(loaded.scene.width, 200);
  EXPECT_EQ(loaded.scene.height, 100);
  // Mitsuba's +x lies to the left in the picture, here -x in the world.
  const CameraRays rays(camera, 200, 100);
  const Ray left = rays.ray({0, 50}, {}), right = rays.ray({200, 50}, {});
  EXPECT_NEAR(left.d.x, -0.5f, 1e-5f);  // half of 60 degrees
  EXPECT_NEAR(right.d.x, 0.5f, 1e-5f);
}

TEST(MitsubaSensor, AMirroringMapMirrorsThePicture) {
  const LoadedScene loaded = load(
      with_sensor("<sensor type=\"perspective\"><float name=\"fov\" value=\"90\"/>"
                  "<transform name=\"toWorld\"><scale x=\"-1\"/>"
                  "<lookat origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/></transform></sensor>"));
  const CameraRays rays(loaded.scene.camera, 100, 100);
  EXPECT_GT(rays.ray({0, 50}, {}).d.x, 0);
  EXPECT_LT(rays.ray({100, 50}, {}).d.x, 0);
  EXPECT_GT(rays.ray({50, 0}, {}).d.y, 0);
}

TEST(MitsubaSensor, FieldOfViewByEachAxis) {
  const auto fov = [](const std::string& parameters) {
    return load(with_sensor("<sensor type=\"perspective\">" + parameters +
                            "<film type=\"hdrfilm\"><integer name=\"width\" value=\"160\"/>"
                            "<integer name=\"height\" value=\"120\"/></film></sensor>"))
        .scene.camera.vertical_fov_deg;
  };
  const std::string ninety = "<float name=\"fov\" value=\"90\"/>";
  const auto axis = [&](const char* name) {
    return fov(ninety + "<string name=\"fovAxis\" value=\"" + name + "\"/>");
  };
  const float x = 2 * std::atan(0.75f) * 180 / kPi;
  EXPECT_NEAR(fov(ninety), x, 1e-3f);
  EXPECT_NEAR(axis("x"), x, 1e-3f);
  EXPECT_NEAR(axis("larger"), x, 1e-3f);
  EXPECT_NEAR(axis("y"), 90, 1e-3f);
  EXPECT_NEAR(axis("smaller"), 90, 1e-3f);
  EXPECT_NEAR(axis("diagonal"), 2 * std::atan(0.6f) * 180 / kPi, 1e-3f);
  // 35 mm film: 43.27 mm across, of which 3/5 are the height of 4:3.
  const float film = 2 * std::atan(0.6f * 43.2666f / 2 / 44) * 180 / kPi;
  EXPECT_NEAR(fov("<string name=\"focalLength\" value=\"44mm\"/>"), film, 1e-3f);
  EXPECT_NEAR(fov("<float name=\"focal_length\" value=\"44\"/>"), film, 1e-3f);
}

TEST(MitsubaSensor, AWindowOfTheFilmIsThePicture) {
  const test::SceneFolder folder;
  const auto sensor = [&folder](const std::string& offset, const std::string& crop) {
    const auto integer = [](const char* name, int value) {
      return "<integer name=\"" + std::string(name) + "\" value=\"" + std::to_string(value) +
             "\"/>";
    };
    return folder.load(
        "a.xml", with_sensor("<sensor type=\"perspective\"><float name=\"fov\" value=\"90\"/>" +
                             offset + "<film type=\"hdrfilm\">" + integer("width", 200) +
                             integer("height", 100) + crop + "</film></sensor>"));
  };
  const std::string crop =
      "<integer name=\"cropWidth\" value=\"50\"/><integer name=\"cropHeight\" value=\"20\"/>"
      "<integer name=\"cropOffsetX\" value=\"150\"/><integer name=\"cropOffsetY\" value=\"0\"/>";
  const auto window = sensor("", crop);
  ASSERT_TRUE(window.ok()) << window.error().text();
  EXPECT_EQ(window.value().warnings.size(), 1u);  // nothing emits light
  const Scene& scene = window.value().scene;
  EXPECT_EQ(scene.width, 50);
  EXPECT_EQ(scene.height, 20);
  // 75 pixels to the right, 40 up; the film's half height is 1/2.
  EXPECT_NEAR(scene.camera.shift.x, 1.5f, 1e-6f);
  EXPECT_NEAR(scene.camera.shift.y, 2, 1e-6f);
  EXPECT_NEAR(scene.camera.vertical_fov_deg, 2 * std::atan(0.1f) * 180 / kPi, 1e-3f);
  const auto moved = sensor("<float name=\"principalPointOffsetX\" value=\"0.25\"/>", "");
  ASSERT_TRUE(moved.ok());
  EXPECT_NEAR(moved.value().scene.camera.shift.x, 0.25f, 1e-6f);
  EXPECT_EQ(moved.value().scene.camera.shift.y, 0);
  const auto outside = sensor("", "<integer name=\"cropOffsetX\" value=\"200\"/>");
  ASSERT_FALSE(outside.ok());
  EXPECT_NE(outside.error().text().find("expected a whole number from 0, below 200"),
            std::string::npos);
}

TEST(MitsubaShape, ColorsOfVerticesCountWhereAMaterialAsksForThem) {
  const test::SceneFolder folder;
  folder.write("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
  const auto count = [&folder](const std::string& bsdf) {
    const LoadedScene loaded =
        load("<scene version=\"3.0.0\">" + kMitsubaSensor +
                 "<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/>" + bsdf +
                 "</shape></scene>",
             folder);
    return loaded.scene.meshes.at(0).colors.size();
  };
  const std::string red = "<bsdf type=\"diffuse\"/>";
  const std::string colored =
      "<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"mesh_attribute\">"
      "<string name=\"name\" value=\"vertex_color\"/></texture></bsdf>";
  EXPECT_EQ(count(red), 0u);
  EXPECT_EQ(count(colored), 3u);
  EXPECT_EQ(count("<bsdf type=\"twosided\">" + colored + "</bsdf>"), 3u);
  EXPECT_EQ(count("<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/>" + red +
                  colored + "</bsdf>"),
            3u);
}

TEST(MitsubaShape, ALightWithoutABsdfReflectsNothing) {
  const std::string light = "<emitter type=\"area\"/>", red = "<bsdf type=\"diffuse\"/>";
  const auto albedo = [](const std::string& parts) {
    const LoadedScene loaded = load("<scene version=\"0.6.0\">" + kMitsubaSensor +
                                    "<shape type=\"rectangle\">" + parts + "</shape></scene>");
    return loaded.scene.materials.at(0).reflectance.value;
  };
  EXPECT_EQ(albedo(light), Rgb{0.0f});
  EXPECT_EQ(albedo(light + red), Rgb{0.5f});
  EXPECT_EQ(albedo(""), Rgb{0.5f});
}

TEST(MitsubaSensor, OrthographicSpansItsMapAcross) {
  const auto of = [](const std::string& type, const std::string& scale) {
    return load(with_sensor("<sensor type=\"" + type + "\"><transform name=\"toWorld\"><scale " +
                            scale +
                            "/><lookat origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/>"
                            "</transform><float name=\"apertureRadius\" value=\"0.1\"/>"
                            "<film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/>"
                            "<integer name=\"height\" value=\"100\"/></film></sensor>"));
  };
  const LoadedScene loaded = of("orthographic", "value=\"3\"");
  const Camera& camera = loaded.scene.camera;
  EXPECT_EQ(camera.projection, Projection::kOrthographic);
  EXPECT_NEAR(camera.height, 3, 1e-5f);  // 6 across, half as high
  EXPECT_EQ(camera.aperture_radius, 0);
  EXPECT_EQ(loaded.warnings.size(), 1u);  // nothing emits light
  const CameraRays rays(camera, 200, 100);
  EXPECT_NEAR(rays.ray({0, 50}, {}).o.x, -3, 1e-5f);
  EXPECT_EQ(of("telecentric", "value=\"3\"").scene.camera.aperture_radius, 0.1f);
  EXPECT_EQ(of("orthographic", "x=\"3\"").warnings.size(), 2u);
}

TEST(MitsubaSensor, SphericalLooksAllAroundItsZ) {
  const LoadedScene loaded = load(
      with_sensor("<sensor type=\"spherical\"><transform name=\"toWorld\"><lookat origin=\"1 2 3\" "
                  "target=\"1 2 -7\" up=\"0 1 0\"/></transform></sensor>"));
  EXPECT_EQ(loaded.scene.camera.projection, Projection::kEquirectangular);
  EXPECT_EQ(loaded.warnings.size(), 1u);  // nothing emits light
  const CameraRays rays(loaded.scene.camera, 8, 4);
  EXPECT_LT(rays.ray({4, 2}, {}).d.z, -0.99f);
  EXPECT_GT(rays.ray({6, 2}, {}).d.x, 0.99f);
}

// Mitsuba counts edges: 1 shows lights alone, 2 their light on surfaces.
TEST(MitsubaIntegrator, DepthIsTakenWhereItIsGiven) {
  const auto depth = [](const std::string& integrator) {
    return load(mitsuba_scene(integrator)).scene.max_depth;
  };
  EXPECT_EQ(depth(""), 128);
  EXPECT_EQ(depth("<integrator type=\"path\"/>"), 128);
  EXPECT_EQ(
      depth("<integrator type=\"path\"><integer name=\"maxDepth\" value=\"-1\"/></integrator>"),
      128);
  EXPECT_EQ(depth("<integrator type=\"guided_path\"><integer name=\"max_depth\" value=\"5\"/>"
                  "<string name=\"budget\" value=\"$budget\"/></integrator>"),
            5);
  EXPECT_EQ(
      depth("<integrator type=\"$method\"><integer name=\"maxDepth\" value=\"$d\"/></integrator>"),
      128);
  EXPECT_EQ(depth("<integrator type=\"aov\"><integrator type=\"path\">"
                  "<integer name=\"max_depth\" value=\"7\"/></integrator></integrator>"),
            7);
  EXPECT_EQ(depth("<integrator type=\"direct\"/>"), 2);
}

TEST(MitsubaShape, FrontsFaceAsMitsubasDo) {
  const std::string mirror = "<transform name=\"toWorld\"><scale z=\"-1\"/></transform>";
  const auto meshes = [](const std::string& shapes) {
    return load("<scene version=\"0.6.0\">" + kMitsubaSensor + shapes + "</scene>").scene.meshes;
  };
  const auto shape = [](const std::string& type, const std::string& inside) {
    return "<shape type=\"" + type + "\">" + inside + "</shape>";
  };
  const std::string flip = "<boolean name=\"flipNormals\" value=\"true\"/>";
  EXPECT_EQ(test::front(meshes(shape("rectangle", ""))[0], 0), (Vec3{0, 0, 1}));
  EXPECT_EQ(test::front(meshes(shape("rectangle", flip))[0], 0), (Vec3{0, 0, -1}));
  EXPECT_EQ(test::front(meshes(shape("rectangle", mirror))[0], 0), (Vec3{0, 0, -1}));
  EXPECT_EQ(test::front(meshes(shape("disk", ""))[0], 0), (Vec3{0, 0, 1}));
  for (const bool flipped : {false, true}) {
    for (const std::string& map : {std::string(), mirror}) {
      const Mesh mesh = meshes(shape("cube", map + (flipped ? flip : "")))[0];
      ASSERT_FALSE(mesh.triangles.empty());
      for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const float out = dot(test::front(mesh, i), mesh.positions[mesh.triangles[i][0]]);
        EXPECT_EQ(out > 0, !flipped) << i;
      }
    }
  }
}

TEST(MitsubaShape, CurvedShapesHaveTheExactArea) {
  const auto area = [](const std::string& shape) {
    const Scene scene = load("<scene>" + kMitsubaSensor + shape + "</scene>").scene;
    double sum = 0;
    for (const auto& t : scene.meshes[0].triangles) {
      const auto& p = scene.meshes[0].positions;
      sum += double{length(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]))} / 2;
    }
    return sum;
  };
  EXPECT_NEAR(area("<shape type=\"disk\"/>") / std::numbers::pi, 1, 1e-5);
  EXPECT_NEAR(area("<shape type=\"cylinder\"><float name=\"radius\" value=\"2\"/>"
                   "<point name=\"p0\" x=\"1\"/><point name=\"p1\" value=\"1 0 5\"/></shape>") /
                  (20 * std::numbers::pi),
              1, 1e-5);
}

const std::string kQuadObj =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\n"
    "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

// Mitsuba's v = 0 is a picture's top; its OBJ reader turns v around, its PLY reader does not.
TEST(MitsubaShape, TextureCoordinatesHaveVUpward) {
  const test::SceneFolder folder;
  folder.write("a.obj", kQuadObj);
  folder.write("a.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nproperty float u\nproperty float v\nelement face 1\n"
               "property list uchar int vertex_indices\nend_header\n"
               "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 0.75\n3 0 1 2\n");
  const auto last_v = [&](const std::string& type, const std::string& inside) {
    const LoadedScene loaded = load("<scene>" + kMitsubaSensor + "<shape type=\"" + type +
                                        "\"><string name=\"filename\" value=\"a." + type + "\"/>" +
                                        inside + "</shape></scene>",
                                    folder);
    return loaded.scene.meshes.at(0).uvs.back().y;
  };
  EXPECT_EQ(last_v("obj", ""), 0.75f);
  EXPECT_EQ(last_v("obj", "<boolean name=\"flipTexCoords\" value=\"false\"/>"), 0.25f);
  EXPECT_EQ(last_v("ply", ""), 0.25f);
  EXPECT_EQ(last_v("ply", "<boolean name=\"flip_tex_coords\" value=\"true\"/>"), 0.75f);
}

TEST(MitsubaShape, NormalsAreMadeUnlessRefused) {
  const test::SceneFolder folder;
  folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n");  // a right angle
  const auto mesh = [&](const std::string& inside) {
    return load("<scene>" + kMitsubaSensor +
                    "<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/>" + inside +
                    "</shape></scene>",
                folder)
        .scene.meshes.at(0);
  };
  const Mesh smooth = mesh("");
  const Vec3 n = smooth.normals.at(smooth.triangles[0][0]);  // of the shared edge
  EXPECT_NEAR(n.y, std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(n.z, std::sqrt(0.5f), 1e-5f);
  EXPECT_TRUE(mesh("<boolean name=\"faceNormals\" value=\"true\"/>").normals.empty());
  const Mesh sharp = mesh("<float name=\"maxSmoothAngle\" value=\"60\"/>");
  EXPECT_EQ(sharp.normals.at(sharp.triangles[0][0]), (Vec3{0, 0, 1}));
  const Mesh round = mesh("<float name=\"maxSmoothAngle\" value=\"100\"/>");
  EXPECT_NEAR(round.normals.at(round.triangles[0][0]).z, std::sqrt(0.5f), 1e-5f);
}

TEST(MitsubaShape, InstancesPlaceAGroupsMeshes) {
  const Scene scene =
      load(
          "<scene>" + kMitsubaSensor +
          "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/><shape type=\"disk\"/></shape>"
          "<shape type=\"instance\"><ref id=\"g\"/></shape>"
          "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"toWorld\">"
          "<translate x=\"5\"/></transform></shape></scene>")
          .scene;
  EXPECT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.instances[3].mesh, MeshId(1));
  EXPECT_EQ(scene.instances[3].to_world.rows[0][3], 5);
}

TEST(MitsubaEmitter, AreaLightsEmitFromTheirFront) {
  const Scene scene =
      load(mitsuba_bsdf("<emitter type=\"area\"><rgb name=\"radiance\" value=\"17, 12, 4\"/>"
                        "</emitter><bsdf type=\"diffuse\"/>"))
          .scene;
  const Material& m = scene.materials[scene.meshes[0].material.value];
  EXPECT_EQ(m.emission.value, (Rgb{17, 12, 4}));
  EXPECT_FALSE(m.emission_two_sided);
}

TEST(MitsubaEmitter, LightsWithoutAnExtent) {
  const Scene scene =
      load(mitsuba_scene(
               "<emitter type=\"point\"><spectrum name=\"intensity\" value=\"3\"/>"
               "<point name=\"position\" x=\"1\" y=\"2\" z=\"3\"/></emitter>"
               "<emitter type=\"spot\"><transform name=\"toWorld\"><lookat origin=\"0 5 0\""
               " target=\"0 0 0\" up=\"1 0 0\"/></transform>"
               "<float name=\"cutoffAngle\" value=\"40\"/></emitter>"
               "<emitter type=\"directional\"><vector name=\"direction\" y=\"-2\"/>"
               "<rgb name=\"irradiance\" value=\"1 2 3\"/></emitter>"
               "<emitter type=\"constant\"><rgb name=\"radiance\" value=\".5\"/></emitter>"))
          .scene;
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].position, (Vec3{1, 2, 3}));
  EXPECT_EQ(scene.lights[0].intensity, Rgb{3.0f});
  EXPECT_EQ(scene.lights[1].kind, LightKind::kSpot);
  EXPECT_EQ(scene.lights[1].direction, (Vec3{0, -1, 0}));
  EXPECT_NEAR(scene.lights[1].outer_rad, 40 * kPi / 180, 1e-6f);
  EXPECT_NEAR(scene.lights[1].inner_rad, 30 * kPi / 180, 1e-6f);
  EXPECT_EQ(scene.lights[2].direction, (Vec3{0, -1, 0}));
  EXPECT_EQ(scene.lights[2].intensity, (Rgb{1, 2, 3}));
  EXPECT_EQ(scene.environment.radiance, Rgb{0.5f});
}

TEST(MitsubaScene, FaultsNameTheLine) {
  const test::SceneFolder folder;
  folder.write("not.obj", "v 0 0\n");
  folder.write("not.png", "nothing");
  const struct {
    std::string text, says;
  } cases[] = {
      {"<scene>\n</scene>", "scene.xml:1: expected a <sensor>"},
      {"<scene>\n" + kMitsubaSensor + "</scene>", "scene.xml:1: expected a <shape>"},
      {mitsuba_scene("<ref id=\"none\"/>"), "scene.xml:4: no element has the id \"none\""},
      {mitsuba_scene("<shape type=\"obj\"/>"), "scene.xml:4: expected a \"filename\""},
      {mitsuba_scene("<shape type=\"obj\">\n<string name=\"filename\" value=\"no.obj\"/></shape>"),
       "scene.xml:5: no such file in the scene's folder: \"no.obj\""},
      {mitsuba_scene(
           "<shape type=\"obj\"><string name=\"filename\" value=\"../../etc/passwd\"/></shape>"),
       "scene.xml:4: "},
      {mitsuba_scene("<shape type=\"obj\"><string name=\"filename\" value=\"not.obj\"/></shape>"),
       "not.obj:1: "},
      {mitsuba_scene("<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>"),
       "scene.xml:4: expected a radius over 0"},
      {mitsuba_scene("<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>"),
       "scene.xml:4: expected a number, got \"$r\""},
      {mitsuba_scene("<shape type=\"sphere\">\n<float name=\"radius\" value=\"nan\"/></shape>"),
       "scene.xml:5: expected a number, got \"nan\""},
      {mitsuba_scene(
           "<shape type=\"cube\"><transform name=\"toWorld\"><scale x=\"0\"/></transform></shape>"),
       "scene.xml:4: expected a transform that can be undone"},
      {mitsuba_scene("<shape type=\"cube\"><transform name=\"toWorld\">\n<matrix value=\"1 2 "
                     "3\"/></transform></shape>"),
       "scene.xml:5: expected 16 numbers, or 9, got 3"},
      {mitsuba_scene(
           "<shape type=\"cube\"><transform name=\"toWorld\">\n<spin/></transform></shape>"),
       "scene.xml:5: expected translate, rotate, scale, lookat or matrix, got <spin>"},
      {mitsuba_scene("<shape type=\"cube\"><transform name=\"toWorld\">\n"
                     "<lookat origin=\"1 1 1\" target=\"1 1 1\"/></transform></shape>"),
       "scene.xml:5: expected a target away from the origin"},
      {mitsuba_scene("<shape type=\"cube\"><boolean name=\"flipNormals\" value=\"yes\"/></shape>"),
       "scene.xml:4: expected \"true\" or \"false\", got \"yes\""},
      {mitsuba_scene("<shape type=\"cube\"><transform name=\"toWorld\"><translate "
                     "x=\"1e9\"/></transform></shape>"),
       "scene.xml:4/positions/0: expected numbers within 1e6 m"},
      {mitsuba_bsdf("<bsdf type=\"twosided\"/>"), "scene.xml:3: expected a BSDF within twosided"},
      {mitsuba_bsdf("<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>"),
       "scene.xml:3: expected BSDFs of at most 32 levels, no cycles"},
      {mitsuba_bsdf("<bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"cheese\"/></bsdf>"),
       "scene.xml:3: expected the name of a material"},
      {mitsuba_bsdf("<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"-1\"/></bsdf>"),
       "scene.xml:3: expected a roughness from 0"},
      {mitsuba_bsdf("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 2\"/></bsdf>"),
       "scene.xml:3: expected 1 or 3 numbers, got 2"},
      {mitsuba_bsdf("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"-1\"/></bsdf>"),
       "scene.xml:3: expected numbers from 0"},
      {mitsuba_bsdf(
           "<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" value=\"400:1 300:1\"/></bsdf>"),
       "scene.xml:3: expected wavelengths that rise"},
      {mitsuba_bsdf(
           "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\"/></bsdf>"),
       "scene.xml:3: expected a \"filename\" of the bitmap"},
      {mitsuba_bsdf("<bsdf type=\"diffuse\"><texture type=\"scale\" name=\"reflectance\" id=\"t\">"
                    "<ref id=\"t\"/></texture></bsdf>"),
       "scene.xml:3: expected textures of at most 16 levels"},
      {with_sensor("\n<sensor type=\"perspective\">\n<float name=\"fov\" value=\"180\"/></sensor>"),
       "scene.xml:3: expected an angle over 0 and under 180"},
      {with_sensor("\n<sensor type=\"perspective\"><film type=\"hdrfilm\">\n"
                   "<integer name=\"width\" value=\"1000000\"/></film></sensor>"),
       "scene.xml:3: expected a whole number of 1..8192"},
  };
  for (const auto& c : cases) {
    const std::string failure = folder.failure("scene.xml", c.text);
    EXPECT_TRUE(failure.starts_with(c.says)) << c.text << "\n-> " << failure;
  }
}

TEST(MitsubaScene, TheSameWarningIsSaidOnceWithACount) {
  const test::SceneFolder folder;
  const std::string shape =
      "<shape type=\"cube\"><bsdf type=\"diffuse\"><float name=\"shine\" value=\"1\"/></bsdf>"
      "</shape>\n";
  const auto of = [&](int count) {
    std::string body = "<emitter type=\"constant\"/>\n";
    for (int i = 0; i < count; ++i) body += shape;
    const auto loaded = folder.load("scene.xml", mitsuba_scene(body));
    EXPECT_TRUE(loaded.ok());
    return loaded.value().warnings;
  };
  const std::string once = "scene.xml:5: \"shine\" of diffuse is left out";
  EXPECT_EQ(of(1), std::vector<std::string>{once});
  EXPECT_EQ(of(2), std::vector<std::string>{once + " (and in 1 more place)"});
  EXPECT_EQ(of(9), std::vector<std::string>{once + " (and in 8 more places)"});
}

// Other programs write elements of their own between Mitsuba's.
TEST(MitsubaScene, ForeignElementsAreSkippedWhereTheValueIsThere) {
  const test::SceneFolder folder;
  const auto load = [&](const std::string& bsdf, const std::string& transform) {
    return folder.load("scene.xml",
                       mitsuba_scene("<emitter type=\"constant\"/>\n<shape type=\"cube\">"
                                     "<bsdf type=\"diffuse\">" +
                                     bsdf + "</bsdf><transform name=\"toWorld\">" + transform +
                                     "</transform></shape>"));
  };
  const std::string color = "<rgb name=\"reflectance\" value=\"0.25\"/>",
                    foreign = "<lux name=\"reflectance\" value=\"7\"/>",
                    move = "<translate x=\"1\"/>";
  const auto loaded = load("<meta/>" + foreign + color, "<pivot x=\"9\"/>" + move);
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& scene = loaded.value().scene;
  EXPECT_EQ(scene.materials.back().reflectance.value, Rgb{0.25f});
  EXPECT_EQ(scene.meshes.back().positions[0].x, 2);
  EXPECT_EQ(
      loaded.value().warnings,
      (std::vector<std::string>{"scene.xml:5: <meta> is no element of Mitsuba and is left out",
                                "scene.xml:5: <lux> is no element of Mitsuba and is left out",
                                "scene.xml:5: <pivot> is no element of Mitsuba and is left out"}));
  EXPECT_FALSE(load(foreign, move).ok());
  EXPECT_FALSE(load(color, "<pivot x=\"9\"/>").ok());
}

TEST(MitsubaScene, WhatIsNotReadIsAWarningOrStrictlyAnError) {
  const test::SceneFolder folder;
  const std::string unknown[] = {
      "<shape type=\"hair\"/>",
      "<emitter type=\"collimated\"/>",
      "<shape type=\"cube\"><bsdf type=\"irawan\"/></shape>",
      "<shape type=\"cube\"><medium type=\"homogeneous\" name=\"interior\"/></shape>",
      "<shape type=\"cube\"><bsdf type=\"diffuse\"><texture type=\"wireframe\" "
      "name=\"reflectance\"/>"
      "</bsdf></shape>",
      "<shape type=\"cube\"><bsdf type=\"diffuse\"><float name=\"shine\" "
      "value=\"1\"/></bsdf></shape>",
  };
  for (const std::string& body : unknown) {
    const auto path = folder.write("scene.xml", mitsuba_scene(body));
    const auto loaded = load_scene(path);
    ASSERT_TRUE(loaded.ok()) << loaded.error().text();
    const std::vector<std::string>& warnings = loaded.value().warnings;
    ASSERT_FALSE(warnings.empty()) << body;
    EXPECT_TRUE(warnings[0].starts_with("scene.xml:4: ")) << warnings[0];
    const auto strict = load_scene(path, {{}, true, {}});
    ASSERT_FALSE(strict.ok());
    EXPECT_EQ(strict.error().text(), warnings[0]);
    EXPECT_EQ(strict.error().code, ErrorCode::kUnsupported);
  }
  const auto plain = folder.write("scene.xml", mitsuba_scene("<shape type=\"cube\"/>"));
  EXPECT_TRUE(load_scene(plain, {{}, true, {}}).ok());
}

}  // namespace
}  // namespace qray
