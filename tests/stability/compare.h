// Every method against `none` on one scene: many small jobs of different seeds, their means tested,
// their errors compared. One thread calls; two render.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/stability/report.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"

namespace qray::test {

struct SeedOptions {
  int seeds = 48;
  int regions = 2;  // a side: means are taken over regions x regions blocks
  // The table that a method's jobs start from; empty: they start cold.
  std::function<std::optional<TableFile>(const std::string& method)> table;
  // Whether check_methods() looks at a method; empty: at all. For settings that others do not have.
  std::function<bool(const std::string& method)> compared = {};
};

// What the jobs of one method made.
struct Sampled {
  std::string method;
  bool unbiased = true;  // claimed
  uint64_t dropped_samples = 0;
  std::vector<std::vector<double>> means;  // by seed: of the picture, then of its regions
  std::vector<double> relmse;              // by seed; empty without a reference
  size_t states = 0, table_bytes = 0;      // of the last job

  double mean() const;
};

// Renders `settings`, its method replaced, with seeds 1, 2, 3 ... `scale` multiplies the pictures'
// values before they are looked at.
Sampled sample_seeds(const PreparedScene& scene, RenderSettings settings, std::string_view method,
                     const SeedOptions& options, const Image* reference = nullptr, float scale = 1);
// `none` with so many times the samples, and a seed that sample_seeds() does not use.
Image reference_of(const PreparedScene& scene, RenderSettings settings, int times);

// Is the mean of every region that of `truth` (sampled with as many seeds)? The largest |z|; fails
// the test where chance does not explain it.
double expect_same_means(const Sampled& sampled, const Sampled& truth, const std::string& where);

// What must hold of every method on any scene: no sample dropped; the same means as `truth`, if it
// claims no bias; `adaptive` has at most 1.1 times the error of `none`. Tells the row, `label`
// first. `none`: nullptr where errors mean nothing.
void check_method(const Row& row, const std::string& label, const Sampled& sampled,
                  const Sampled& truth, const Sampled* none);

// Every method, and `adaptive` also with its gate open: in pictures as small as these, a gate that
// does its duty keeps the guide from ruling at all.
std::vector<std::string> compared_methods();

// All of it: those methods on one scene.
void check_methods(const Row& row, const std::string& label, const PreparedScene& scene,
                   const RenderSettings& settings, const SeedOptions& options = {});

}  // namespace qray::test
