// Every method against `none` on one scene: many small jobs of different seeds, their means tested,
// their errors compared. One thread calls; two render.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/stability/failure_mode.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"

namespace qray::test {

// `adaptive` with its gate open. A gate that does its duty keeps the guide out of most of the small
// pictures of this suite, so that `adaptive` alone would only be compared with itself.
constexpr std::string_view kOpenGuide = "adaptive:gate=off";

// Every method, and kOpenGuide. These are variants (core/settings/variant.h).
std::vector<std::string> compared_methods();
// The same without `none`: those that keep a table.
std::vector<std::string> learning_methods();

// small_settings() of a variant.
RenderSettings variant_settings(std::string_view variant, int side_px, int samples,
                                uint64_t seed = 1);

struct SeedOptions {
  int seeds = 48;
  int regions = 2;  // a side: means are taken over regions x regions blocks
  // The table that the jobs of a variant start from; empty: they start cold.
  std::function<std::optional<TableFile>(const std::string& variant)> table;
  // The largest error that kOpenGuide may have, over that of `none`. Above 1.1 only where the open
  // guide is known to make noise: the page of the failure mode says so.
  double open_guide_error = 1.1;
  bool guide_rules = true;  // false: nothing is learned that kOpenGuide could follow
  // Renders the reference. Caustics need one that aims at them: `none` misses most of them.
  std::string reference_method = "none";
  // False where a few pictures own the error: the mean over seeds alone decides, since the median
  // favours a method whose pictures miss the light.
  bool median_decides = true;
  std::vector<std::string> methods = learning_methods();  // compared with `none`
};

// What the jobs of one variant made.
struct Sampled {
  std::string method;
  bool unbiased = true;  // claimed
  uint64_t dropped_samples = 0;
  double allowed_error = 0;  // over that of `none`; 0: any
  bool median_decides = true;
  std::vector<std::vector<double>> means;  // by seed: of the picture, then of its regions
  std::vector<double> relmse;              // by seed; empty without a reference
  size_t states = 0, table_bytes = 0;      // of the last job

  double mean() const;
};

// Renders `settings`, changed as the variant says, with seeds 1, 2, 3 ... `scale` multiplies the
// pictures' values before they are looked at.
Sampled sample_seeds(const PreparedScene& scene, RenderSettings settings, std::string_view variant,
                     const SeedOptions& options, const Image* reference = nullptr, float scale = 1);
// A picture with so many times the samples, and a seed that sample_seeds() does not use.
Image reference_of(const PreparedScene& scene, RenderSettings settings, int times,
                   std::string_view method = "none");

// Is the mean of every region that of `truth` (sampled with as many seeds)? The largest |z|; fails
// the test where chance does not explain it.
double expect_same_means(const Sampled& sampled, const Sampled& truth, const std::string& where);

// What must hold of every method on any scene: no sample is dropped; the means are those of
// `truth`, if it claims no bias; the error is at most its allowed one. Writes the figures to the
// page, in the row of `label`. `none`: nullptr where errors mean nothing.
void check_method(const FailureMode& mode, const std::string& label, const Sampled& sampled,
                  const Sampled& truth, const Sampled* none);

// All of it: every variant on one scene. `none` always starts cold.
void check_methods(const FailureMode& mode, const std::string& label, const PreparedScene& scene,
                   const RenderSettings& settings, const SeedOptions& options = {});

}  // namespace qray::test
