// Discrete densities with their samplers (pbrt-v4, A.1). Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace qray {

// Vose's alias method: picks i with probability weight[i] / sum in constant time. Immutable.
class AliasTable {
 public:
  AliasTable() = default;
  explicit AliasTable(std::span<const float> weights);  // not empty; finite, >= 0; all 0: uniform

  struct Pick {
    uint32_t index = 0;
    float probability = 0;
  };
  Pick sample(float u) const {
    const uint32_t bins = static_cast<uint32_t>(bins_.size());
    const float scaled = u * static_cast<float>(bins);
    const uint32_t slot = std::min(static_cast<uint32_t>(scaled), bins - 1);
    const Bin& bin = bins_[slot];
    const uint32_t index = scaled - static_cast<float>(slot) < bin.keep ? slot : bin.alias;
    return {index, bins_[index].probability};
  }
  float probability(uint32_t index) const { return bins_[index].probability; }
  size_t size() const { return bins_.size(); }

 private:
  struct Bin {
    float keep = 1;         // chance to stay in this bin
    uint32_t alias = 0;     // where else
    float probability = 0;  // of this index
  };
  std::vector<Bin> bins_;
};

// Fills `cdf` (one more than the weights, from 0 to 1) and returns their sum; all 0: uniform.
double fill_cdf(std::span<const float> weights, std::span<float> cdf);

// The interval of a cdf that holds u, and u's position in it.
struct CdfPick {
  int index;
  float offset;  // [0, 1)
};
// `guide` (fill_guide()) narrows the search to a few intervals side by side in memory (Chen and
// Asau 1974): the same pick as by a search of the whole, so that strata stay strata.
CdfPick pick_by_cdf(std::span<const float> cdf, std::span<const uint32_t> guide, float u);
// For each of guide.size() - 1 equal parts of [0, 1], a power of two, the interval of the cdf in
// which it begins, and in which the last one ends.
void fill_guide(std::span<const float> cdf, std::span<uint32_t> guide);

}  // namespace qray
