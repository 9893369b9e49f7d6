// Methods that claim to be unbiased have the mean of `none`; the thesis' as published has not.
#include <gtest/gtest.h>

#include "core/job/run_job.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

constexpr int kSide = 64;    // pixels
constexpr int kRegions = 4;  // a side
constexpr int kSeeds = 24;

struct Means {
  test::Moments whole;  // over seeds, of the picture's mean luminance
  std::vector<test::Moments> regions = std::vector<test::Moments>(kRegions * kRegions);
};

std::shared_ptr<const PreparedScene> included_scene(const std::string& name) {
  auto scene = load_and_prepare_scene(
      std::filesystem::path(QRAY_SOURCE_DIR) / "scenes" / name / "scene.json", 2);
  EXPECT_TRUE(scene.ok()) << scene.error().text();
  return scene.value();
}

RenderSettings settings_of(const std::string& method, int samples, uint64_t seed, bool nee) {
  RenderSettings s;
  s.method = method;
  s.nee = nee;
  s.width = s.height = kSide;
  s.samples = samples;
  s.seed = seed;
  s.max_depth = 8;
  return s;
}

Result<JobResult> run(const PreparedScene& scene, const RenderSettings& settings, Film& film,
                      const std::optional<TableFile>& table) {
  static TaskPool pool(2);
  RenderObserver observer;
  return run_job(scene, settings, table, film, pool, observer, {}, SteadyClock());
}

Means means_of(const PreparedScene& scene, const std::string& method, int samples, bool nee,
               const std::optional<TableFile>& table = {}) {
  Means means;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Film film(kSide, kSide);
    const auto job = run(scene, settings_of(method, samples, seed, nee), film, table);
    EXPECT_TRUE(job.ok()) << job.error().text();
    EXPECT_EQ(job.value().stats.dropped_samples, 0u);
    const Image image = film.develop();
    double sum = 0;
    std::vector<double> region(means.regions.size());
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double v = luminance(image.rgb(x, y));
        sum += v;
        region[static_cast<size_t>(y * kRegions / kSide * kRegions + x * kRegions / kSide)] += v;
      }
    means.whole.add(sum / (kSide * kSide));
    for (size_t i = 0; i < region.size(); ++i) means.regions[i].add(region[i]);
  }
  return means;
}

TableFile learned(const PreparedScene& scene, bool nee) {
  Film film(kSide, kSide);
  RenderSettings settings = settings_of("huang", 64, 99, nee);
  settings.learning_samples = 16;
  auto job = run(scene, settings, film, {});
  EXPECT_TRUE(job.ok());
  return *std::move(job).value().table;
}

class Unbiased : public ::testing::TestWithParam<const char*> {};

TEST_P(Unbiased, HuangHasTheMeanOfNone) {
  const auto scene = included_scene(GetParam());
  for (bool nee : {true, false}) {
    const Means none = means_of(*scene, "none", 16, nee);
    const Means cold = means_of(*scene, "huang", 16, nee);
    const Means warm = means_of(*scene, "huang", 16, nee, learned(*scene, nee));
    for (const Means* huang : {&cold, &warm}) {
      EXPECT_LT(std::abs(test::z_test(huang->whole, none.whole).z), 3)
          << GetParam() << " nee " << nee << ": " << huang->whole.mean() << " against "
          << none.whole.mean() << " +- " << none.whole.standard_error();
      for (size_t i = 0; i < none.regions.size(); ++i)
        EXPECT_GT(test::z_test(huang->regions[i], none.regions[i]).p_value,
                  test::significance(3 * 2 * 2 * kRegions * kRegions))
            << GetParam() << " nee " << nee << " region " << i << ": " << huang->regions[i].mean()
            << " against " << none.regions[i].mean();
    }
  }
}

TEST_P(Unbiased, HuangAsPublishedIsBrighter) {
  const auto scene = included_scene(GetParam());
  const Means none = means_of(*scene, "none", 64, false);
  const Means published = means_of(*scene, "huang-published", 64, false, learned(*scene, false));
  const double ratio = published.whole.mean() / none.whole.mean();
  RecordProperty("brightness_over_truth", std::to_string(ratio));
  std::printf("%s: huang-published is %.2f times as bright as the truth\n", GetParam(), ratio);
  EXPECT_GT(test::z_test(published.whole, none.whole).z, 5);
  EXPECT_GT(ratio, 1.2);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Unbiased,
                         ::testing::Values("cornell-box", "ajar-door", "lamp-room"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace qray
