#include "tests/stability/compare.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/settings/variant.h"

namespace qray::test {
namespace {

// Means tested by the whole suite, about: 65 scenes, 7 variants, 5 regions. More only lowers power.
constexpr int kMeanTests = 2300;
constexpr int kReferenceTimes = 64;
constexpr double kGatedError = 1.1;  // that `adaptive` may have, over that of `none`

double average(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

// Above what is allowed, and not by chance.
void expect_little_error(const Sampled& sampled, const Sampled& none, const std::string& where) {
  Moments excess;
  for (size_t i = 0; i < sampled.relmse.size(); ++i)
    excess.add(sampled.relmse[i] - sampled.allowed_error * none.relmse[i]);
  EXPECT_LT(z_test(excess, 0).z, 3) << where;
  if (!sampled.median_decides) return;
  EXPECT_LE(median(sampled.relmse), sampled.allowed_error * median(none.relmse)) << where;
}

}  // namespace

double Sampled::mean() const {
  Moments m;
  for (const std::vector<double>& picture : means) m.add(picture[0]);
  return m.mean();
}

Sampled sample_seeds(const PreparedScene& scene, RenderSettings settings, std::string_view variant,
                     const SeedOptions& options, const Image* reference, float scale) {
  Sampled sampled;
  sampled.method = variant;
  sampled.median_decides = options.median_decides;
  if (variant == "adaptive") sampled.allowed_error = kGatedError;
  if (variant == kOpenGuide) sampled.allowed_error = options.open_guide_error;
  settings = apply_variant(variant, std::move(settings)).value();
  std::optional<TableFile> table;
  if (options.table) table = options.table(sampled.method);
  for (int i = 1; i <= options.seeds; ++i) {
    settings.seed = static_cast<uint64_t>(i);
    Rendered rendered = render(scene, settings, table);
    for (float& v : rendered.image.data()) v *= scale;
    std::vector<double> means = region_luminances(rendered.image, options.regions);
    means.insert(means.begin(), average(means));
    sampled.means.push_back(std::move(means));
    if (reference) sampled.relmse.push_back(relmse(rendered.image, *reference));
    const RenderStats& stats = rendered.job.stats;
    sampled.unbiased = stats.unbiased;
    sampled.dropped_samples += stats.dropped_samples;
    sampled.states = stats.states;
    sampled.table_bytes = stats.table_bytes;
  }
  return sampled;
}

Image reference_of(const PreparedScene& scene, RenderSettings settings, int times,
                   std::string_view method) {
  settings.method = method;
  settings.seed = 1'000'003;
  settings.samples *= times;
  return render(scene, settings).image;
}

double expect_same_means(const Sampled& sampled, const Sampled& truth, const std::string& where) {
  double largest = 0;
  for (size_t region = 0; region < truth.means[0].size(); ++region) {
    Moments difference, expected;  // of equal seeds: what the camera's rays share cancels
    for (size_t i = 0; i < truth.means.size(); ++i) {
      difference.add(sampled.means[i][region] - truth.means[i][region]);
      expected.add(truth.means[i][region]);
    }
    const ZTest test = z_test(difference, 0, 1e-5 * expected.mean());  // forgive rounding
    if (std::abs(test.z) > std::abs(largest)) largest = test.z;
    EXPECT_GT(test.p_value, significance(kMeanTests))
        << where << ", region " << region << ": " << expected.mean() + difference.mean()
        << " against " << expected.mean() << ", z " << test.z;
  }
  return largest;
}

void check_method(const FailureMode& mode, const std::string& label, const Sampled& sampled,
                  const Sampled& truth, const Sampled* none) {
  const std::string where = sampled.method + ", " + label;
  EXPECT_EQ(sampled.dropped_samples, 0u) << where;
  if (sampled.unbiased) {
    const double z = expect_same_means(sampled, truth, where);
    mode.mean(sampled.method, label,
              &sampled == &truth ? formatted("%.3g", truth.mean()) : formatted("z %.1f", z));
  } else {
    mode.mean(sampled.method, label, formatted("%.2f x", sampled.mean() / truth.mean()));
  }
  if (none && &sampled != none) {
    mode.error(sampled.method, label,
               formatted("%.2f (%.2f)", average(sampled.relmse) / average(none->relmse),
                         median(sampled.relmse) / median(none->relmse)));
    if (sampled.allowed_error > 0) expect_little_error(sampled, *none, where);
  } else if (none) {
    mode.error(sampled.method, label, formatted("%.3g", average(none->relmse)));
  }
}

void check_methods(const FailureMode& mode, const std::string& label, const PreparedScene& scene,
                   const RenderSettings& settings, const SeedOptions& options) {
  const Image reference = reference_of(scene, settings, kReferenceTimes, options.reference_method);
  SeedOptions cold = options;
  cold.table = nullptr;
  const Sampled none = sample_seeds(scene, settings, "none", cold, &reference);
  EXPECT_GT(none.mean(), 0) << label << ": nothing to compare";
  check_method(mode, label, none, none, &none);
  for (const std::string& method : options.methods) {
    const Sampled sampled = sample_seeds(scene, settings, method, options, &reference);
    if (method == kOpenGuide && options.guide_rules) {
      EXPECT_NE(sampled.means, none.means) << label << ": the guide should be open";
    }
    check_method(mode, label, sampled, none, &none);
  }
}

std::vector<std::string> compared_methods() {
  std::vector<std::string> methods(method_names().begin(), method_names().end());
  methods.emplace_back(kOpenGuide);
  return methods;
}

std::vector<std::string> learning_methods() {
  std::vector<std::string> methods = compared_methods();
  std::erase(methods, "none");
  return methods;
}

RenderSettings variant_settings(std::string_view variant, int side_px, int samples, uint64_t seed) {
  return apply_variant(variant, small_settings("none", side_px, samples, seed)).value();
}

}  // namespace qray::test
