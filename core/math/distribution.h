// Discrete and piecewise-constant densities with their samplers (pbrt-v4, A.1 and A.4.5).
// Immutable after construction; any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace qray {

// Vose's alias method: picks i with probability weight[i] / sum in constant time.
class AliasTable {
 public:
  AliasTable() = default;
  explicit AliasTable(std::span<const float> weights);  // not empty; finite, >= 0; all 0: uniform

  struct Pick {
    uint32_t index = 0;
    float probability = 0;
  };
  Pick sample(float u) const {
    const float scaled = u * static_cast<float>(bins_.size());
    const uint32_t slot =
        std::min(static_cast<uint32_t>(scaled), static_cast<uint32_t>(bins_.size() - 1));
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

// A density over the unit square, constant in each of width x height cells.
class PiecewiseConstant2D {
 public:
  PiecewiseConstant2D() = default;
  PiecewiseConstant2D(std::span<const float> weights, int width, int height);

  struct Sample {
    Vec2 uv;
    float pdf = 0;  // with respect to area on the unit square
  };
  Sample sample(Vec2 u) const;
  float pdf(Vec2 uv) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<float> weights_;   // scaled so that the mean is 1
  std::vector<float> row_cdf_;   // height + 1
  std::vector<float> cell_cdf_;  // height rows of width + 1
};

}  // namespace qray
