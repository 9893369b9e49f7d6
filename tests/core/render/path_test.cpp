// Paths are traced side by side; what one brings does not depend on its neighbours.
#include "core/render/path.h"

#include <gtest/gtest.h>

#include "tests/support/render.h"

namespace qray {
namespace {

// Fewer than a batch of rays to lights: light is then added up in the same order in both cases.
constexpr uint32_t kPaths = 96;

std::vector<Rgb> trace(const PreparedScene& scene, const RenderSettings& settings,
                       const Guide* guide, bool alone) {
  const CameraRays camera(scene.scene.camera, settings.width, settings.height);
  PathTracer tracer(scene, scene.lights, settings, guide);
  Sampler sampler(3);
  std::vector<Rgb> light(kPaths);
  for (uint32_t i = 0; i < kPaths; ++i) {
    const uint32_t x = i % 12 * 4, y = i / 12 * 5;
    sampler.start(x, y, 0);
    const Ray ray = camera.ray({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, {});
    tracer.sample(ray, sampler, nullptr, 0, {&light[i]});
    if (alone) tracer.flush();
  }
  tracer.flush();
  EXPECT_EQ(tracer.counters().paths, kPaths);
  return light;
}

TEST(PathTracer, BringsTheSameAloneAndSideBySide) {
  for (const char* name : {"cornell-box", "lamp-room", "many-lights", "glass-caustic", "furnace"}) {
    SCOPED_TRACE(name);
    const auto scene = test::included_scene(name);
    const RenderSettings settings = test::small_settings("none", 48, 1);
    const std::vector<Rgb> alone = trace(*scene, settings, nullptr, true);
    EXPECT_EQ(alone, trace(*scene, settings, nullptr, false));
    EXPECT_NE(alone, std::vector<Rgb>(kPaths));
  }
}

TEST(PathTracer, BringsTheSameAloneAndSideBySideWithAGuide) {
  const auto scene = test::included_scene("lamp-room");
  RenderSettings settings = test::small_settings("adaptive", 48, 64);
  settings.gate = false;
  const test::Rendered taught = test::render(*scene, settings);
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, taught.job.table).value();
  EXPECT_EQ(trace(*scene, settings, guide.get(), true),
            trace(*scene, settings, guide.get(), false));
}

}  // namespace
}  // namespace qray
