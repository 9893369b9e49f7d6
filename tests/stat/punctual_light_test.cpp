// Lights without an extent: their light on a floor in closed form, and methods against each other.
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/random.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr float kAlbedo = 0.8f;

// A floor of 4 m, seen from 10 m above: x to the right, -z up in the picture, 2 m wide.
Scene floor_under(const PunctualLight& light) {
  Scene scene;
  scene.name = "floor";
  test::add_quad(scene, test::add_material(scene, Rgb{kAlbedo}), {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  scene.lights = {light};
  scene.camera.position = {0, 10, 0};
  scene.camera.target = {0, 0, 0};
  scene.camera.up = {0, 0, -1};
  scene.camera.vertical_fov_deg = 2 * std::atan(0.1f) * 180 / kPi;
  return scene;
}

PunctualLight lamp(LightKind kind) {
  PunctualLight light;
  light.kind = kind;
  light.intensity = {3, 2, 1};
  light.position = {0.3f, 0.7f, -0.2f};
  light.direction = normalize(Vec3{0.1f, -1, 0.2f});
  light.inner_rad = 0.3f;
  light.outer_rad = 0.9f;
  return light;
}

// Irradiance of the floor at p, of a light of intensity 1.
double irradiance(const PunctualLight& light, Vec3 p) {
  if (light.kind == LightKind::kDirectional) return -light.direction.y;
  const Vec3 d = p - light.position;
  const double r = length(d), cosine = -d.y / r;
  double share = 1;
  if (light.kind == LightKind::kSpot) {
    const double c = dot(d, light.direction) / r;
    share = light.falloff == SpotFalloff::kLinearAngle
                ? (light.outer_rad - std::acos(c)) / (light.outer_rad - light.inner_rad)
                : (c - std::cos(light.outer_rad)) /
                      (std::cos(light.inner_rad) - std::cos(light.outer_rad));
    share = std::clamp(share, 0.0, 1.0);
    if (light.falloff == SpotFalloff::kCosineSquared) share *= share;
  }
  return share * cosine / (r * r);
}

void expect_closed_form(const PunctualLight& light, bool nee) {
  constexpr int kSide = 32;
  const auto scene = test::prepare(floor_under(light));
  RenderSettings settings = test::small_settings("none", kSide, 64);
  settings.nee = nee;
  const Image image = test::render(*scene, settings).image;
  double brightest = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      // The pixel's mean by 4 x 4 points.
      double mean = 0;
      for (int i = 0; i < 16; ++i) {
        const float u = (static_cast<float>(x) + (static_cast<float>(i % 4) + 0.5f) / 4) / kSide;
        const float v = (static_cast<float>(y) + (static_cast<float>(i / 4) + 0.5f) / 4) / kSide;
        mean += irradiance(light, {2 * u - 1, 0, 2 * v - 1}) / 16;
      }
      const Rgb pixel = image.rgb(x, y);
      for (int c = 0; c < 3; ++c) {
        const double expected = mean * light.intensity[c] * kAlbedo * kInvPi;
        ASSERT_NEAR(pixel[c], expected, 0.01 * expected + 2e-3) << x << ", " << y;
        brightest = std::max(brightest, expected);
      }
    }
  }
  EXPECT_GT(brightest, 0.2);
}

TEST(PunctualLight, AFloorIsAsBrightAsTheClosedForm) {
  PunctualLight linear = lamp(LightKind::kSpot);
  linear.falloff = SpotFalloff::kLinearAngle;
  for (const PunctualLight& light :
       {lamp(LightKind::kPoint), lamp(LightKind::kSpot), linear, lamp(LightKind::kDirectional)}) {
    for (const bool nee : {true, false}) expect_closed_form(light, nee);
  }
}

TEST(PunctualLight, PowerIsTheIntegralOfIntensity) {
  PunctualLight linear = lamp(LightKind::kSpot), hard = linear;
  linear.falloff = SpotFalloff::kLinearAngle;
  hard.inner_rad = hard.outer_rad;
  PunctualLight hard_linear = hard;
  hard_linear.falloff = SpotFalloff::kLinearAngle;
  for (const PunctualLight& light :
       {lamp(LightKind::kPoint), lamp(LightKind::kSpot), linear, hard, hard_linear}) {
    double sum = 0;
    constexpr int kSteps = 20'000;
    const Frame frame(light.direction);
    for (int i = 0; i < kSteps; ++i) {
      const float c = 2 * (static_cast<float>(i) + 0.5f) / kSteps - 1;
      sum += double{light.intensity_toward(frame.to_world({std::sqrt(1 - c * c), 0, c})).g} * 4 *
             kPi / kSteps;
    }
    EXPECT_NEAR(light.power().g / sum, 1, 1e-3);
  }
}

// The room lit by a lamp and a panel, or by lamps alone.
Scene lamp_room(bool panel) {
  Scene scene = test::room();
  if (!panel) scene.meshes.pop_back();
  PunctualLight point = lamp(LightKind::kPoint), spot = lamp(LightKind::kSpot);
  point.position = {-0.6f, 1.7f, 0.3f};
  spot.position = {-0.5f, 0.3f, -0.2f};
  spot.direction = {0, 1, 0};
  scene.lights = {point, spot};
  return scene;
}

test::Moments means(const PreparedScene& scene, const char* method,
                    const std::function<void(RenderSettings&)>& change) {
  test::Moments means;
  for (uint64_t seed = 1; seed <= 16; ++seed) {
    RenderSettings settings = test::small_settings(method, 32, 32, seed);
    change(settings);
    means.add(test::mean_luminance(test::render(scene, settings).image));
  }
  return means;
}

TEST(PunctualLight, MethodsAndSettingsKeepTheMean) {
  const double level = test::significance(2 * 7);
  for (const bool panel : {true, false}) {
    const auto scene = test::prepare(lamp_room(panel));
    const test::Moments plain = means(*scene, "none", [](RenderSettings&) {});
    EXPECT_LT(plain.standard_error(), 0.02 * plain.mean());
    const auto expect_same = [&](const char* what, const test::Moments& other) {
      EXPECT_GT(test::z_test(plain, other).p_value, level)
          << what << ": " << other.mean() << " +- " << other.standard_error() << ", plain "
          << plain.mean() << " +- " << plain.standard_error();
    };
    // Beside a panel that directions can hit; alone, TablesLearnTheirLight has them.
    for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"})
      if (panel)
        expect_same(method, means(*scene, method, [](RenderSettings& s) { s.seed += 100; }));
    expect_same("no nee", means(*scene, "none", [](RenderSettings& s) { s.nee = false; }));
    expect_same("huang, no nee", means(*scene, "huang", [](RenderSettings& s) { s.nee = false; }));
    expect_same("alike", means(*scene, "none", [](RenderSettings& s) { s.light_table = false; }));
  }
}

// Nothing here is hit that emits: what a table knows, it has of surfaces that lamps light.
TEST(PunctualLight, TablesLearnTheirLight) {
  const auto scene = test::prepare(lamp_room(/*panel=*/false));
  for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"}) {
    const RenderSettings settings = test::small_settings(method, 48, 64);
    const auto guide = load_guide(*scene, settings, test::render(*scene, settings).job.table);
    ASSERT_TRUE(guide.ok()) << guide.error().text();
    const GuidePoint at = guide.value()->find({0, 0, 0.3f}, {0, 1, 0});  // on the floor
    ASSERT_TRUE(at.state.valid()) << method;
    float highest = 0, lowest = std::numeric_limits<float>::infinity();
    test::Random random(1);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 up = square_to_uniform_hemisphere(random.next_2d());  // about +z
      const float pdf_w = guide.value()->pdf_w(at, {up.x, up.z, up.y});
      if (up.z < 0.2f) continue;
      highest = std::max(highest, pdf_w / up.z), lowest = std::min(lowest, pdf_w / up.z);
    }
    EXPECT_GT(highest, 2 * lowest) << method;
  }
}

}  // namespace
}  // namespace qray
