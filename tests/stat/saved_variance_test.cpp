// What a path sums of the variance that its guide saved is the difference of second moments with
// and without the guide, where the estimate leaves nothing out: paths of one scattering.
#include <gtest/gtest.h>

#include "core/render/path.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

struct SecondMoments {
  test::Moments square, saved;
};

// Of the samples of a few pixels.
SecondMoments measure(const PreparedScene& scene, const RenderSettings& settings, Guide& guide,
                      bool guided, float deviation) {
  constexpr uint32_t kBatches = 32, kSamples = 4000;
  constexpr int kPixelStep = 12;
  const CameraRays camera(scene.scene.camera, settings.width, settings.height);
  PathTracer tracer(scene, scene.lights, settings, &guide);
  tracer.set_guiding(guided, /*learning=*/true);
  const std::unique_ptr<GuideDelta> delta = guide.make_delta();
  Sampler sampler(guided ? 5 : 6);
  SecondMoments moments;
  for (uint32_t batch = 0; batch < kBatches; ++batch) {
    std::vector<Rgb> light(kSamples);
    std::vector<double> saved(kSamples, 0);
    double square = 0, all_saved = 0;
    for (int y = kPixelStep / 2; y < settings.height; y += kPixelStep)
      for (int x = kPixelStep / 2; x < settings.width; x += kPixelStep) {
        light.assign(kSamples, {});
        saved.assign(kSamples, 0);
        for (uint32_t i = 0; i < kSamples; ++i) {
          sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), batch * kSamples + i);
          const Ray ray = camera.ray({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f},
                                     {0.5f, 0.5f});
          tracer.sample(ray, sampler, delta.get(), deviation, {&light[i], &saved[i]});
        }
        tracer.flush();
        for (uint32_t i = 0; i < kSamples; ++i) {
          square += sqr(static_cast<double>(luminance(light[i])));
          all_saved += saved[i];
        }
      }
    moments.square.add(square / kSamples);
    moments.saved.add(all_saved / kSamples);
  }
  return moments;
}

struct SavedCase {
  const char* scene;
  bool nee;
  float deviation;  // of a pixel's samples: above 0 the guide's roulette is on
};

TEST(SavedVariance, IsTheDifferenceOfSecondMoments) {
  for (const SavedCase& c : {SavedCase{"cornell-box", false, 0},
                             {"cornell-box", true, 0},
                             {"cornell-box", true, 2},
                             {"thesis-room", false, 0}}) {
    SCOPED_TRACE(std::string(c.scene) + (c.nee ? ", nee, deviation " : ", deviation ") +
                 std::to_string(c.deviation));
    const auto scene = test::included_scene(c.scene);
    RenderSettings settings = test::small_settings("adaptive", 48, 64);
    settings.gate = false;
    settings.nee = false;  // so that the guide points at lights, which nee finds as well
    const test::Rendered taught = test::render(*scene, settings);
    const auto guide = load_guide(*scene, settings, taught.job.table).value();
    settings.nee = c.nee;
    settings.max_depth = 2;
    const SecondMoments with = measure(*scene, settings, *guide, /*guided=*/true, c.deviation),
                        without = measure(*scene, settings, *guide, /*guided=*/false, 0);
    EXPECT_EQ(without.saved.mean(), 0);
    const double difference = without.square.mean() - with.square.mean();
    const double error =
        std::hypot(std::hypot(without.square.standard_error(), with.square.standard_error()),
                   with.saved.standard_error());
    EXPECT_NEAR(with.saved.mean(), difference, 4.5 * error);
    EXPECT_TRUE(c.nee || difference > 10 * error) << "the guide saves nothing to speak of";
  }
}

}  // namespace
}  // namespace qray
