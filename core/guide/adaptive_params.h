// Parameters of `adaptive`, and those of the trees of directions that `adaptive` and `ppg` grow.
// docs/guiding.md has what each value of `adaptive` is worth.
#pragma once

namespace qray {

// How DirectionTrees::adapt() cuts and joins the cells of a tree.
struct DirectionParams {
  float shrinkage = 16;  // toward the parent cell's estimate: k, in samples
  // Of what arrives at the place. A cell with more is cut in four; a cut cell with less than a
  // quarter of it is joined again.
  float split_share = 0.03f;
  // By how much a cut must raise the density's second moment, as a part of it: a cut that brings
  // less is taken back. Below 0: no cut is.
  float min_split_gain = 0.001f;
  int max_depth = 6;  // cells are at least 2^-max_depth wide
  bool operator==(const DirectionParams&) const = default;
};

struct AdaptiveParams {
  DirectionParams direction;
  float split_samples = 4000;  // a place that was hit more often in a pass is cut in two
  // The chance to draw from the guide in place of a rough lobe; below 0: each place's own, learned.
  float glossy = -1;
  float keep = 0.7f;      // the least part of what a place knows that a pass keeps
  float uniform = 0.15f;  // the part of DirectionTrees::add_uniform()
  // A place whose directions have a lower GuideInspector::gain() draws from the BSDF alone.
  float min_gain = 1.15f;
  bool lights = true;    // whether it is learned which lights send how much where
  bool caustics = true;  // whether paths aim at where mirrors and glass send light from
  bool by_noise = true;  // whether pixels get more samples where they are noisy
  bool operator==(const AdaptiveParams&) const = default;
};

}  // namespace qray
