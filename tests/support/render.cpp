#include "tests/support/render.h"
#include "tests/support/places.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/image/metrics.h"
#include "core/render/pass_plan.h"

namespace qray::test {

RenderSettings small_settings(const std::string& method, int side_px, int samples, uint64_t seed) {
  RenderSettings settings;
  settings.method = method;
  settings.width = settings.height = side_px;
  settings.samples = samples;
  settings.seed = seed;
  settings.max_depth = 8;
  return settings;
}

Result<Rendered> try_render(const PreparedScene& scene, const RenderSettings& settings,
                            std::optional<TableFile> table) {
  static TaskPool pool(2);
  Film film(settings.width, settings.height);
  RenderObserver observer;
  Result<JobResult> job =
      run_job(scene, settings, std::move(table), film, pool, observer, {}, SteadyClock());
  if (!job) return job.error();
  return Rendered{film.develop(), std::move(job).value()};
}

RenderSettings learning_passes_of(RenderSettings settings) {
  settings.passes.clear();
  PassPlan plan(settings);
  RenderAge age;
  while (plan.learning(age)) {
    age.samples += static_cast<uint64_t>(plan.start(age, 0));
  }
  settings.passes = plan.passes();
  return settings;
}

Rendered render(const PreparedScene& scene, const RenderSettings& settings,
                std::optional<TableFile> table) {
  Result<Rendered> rendered = try_render(scene, settings, std::move(table));
  if (rendered) return std::move(rendered).value();
  ADD_FAILURE() << settings.method << ": " << rendered.error().text();
  return {Image(settings.width, settings.height, 3), {}};
}

std::shared_ptr<const PreparedScene> included_scene(const std::string& name) {
  auto scene = load_and_prepare_scene(test::source_dir() / "scenes" / name / "scene.json", 2);
  QRAY_CHECK(scene.ok());
  return std::move(scene).value();
}

bool same_bits(const Image& a, const Image& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         std::ranges::equal(a.data(), b.data());
}

double mean_luminance(const Image& image) { return region_luminances(image, 1)[0]; }

std::vector<double> region_luminances(const Image& image, int regions) {
  const int w = image.width(), h = image.height();
  std::vector<double> means(static_cast<size_t>(regions * regions));
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      means[static_cast<size_t>(y * regions / h * regions + x * regions / w)] +=
          luminance(image.rgb(x, y));
  for (double& mean : means) mean *= static_cast<double>(regions) * regions / w / h;
  return means;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace qray::test
