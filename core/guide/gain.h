// What a density over cells is worth if the cells pay what was learned of them. Any thread.
#pragma once

#include <span>

namespace qray {

// The second moment of a cell's learned mean, cells drawn by their shares, over that of the same
// estimate with cells drawn by share x weight: sum a m^2 / sum a m^2 / w. `shares` and
// shares x weights sum to 1, weights are positive. With w = m / sum a m this is
// sum a m^2 / (sum a m)^2. 1 without light.
inline float gain_of_cells(std::span<const float> shares, std::span<const float> means,
                           std::span<const float> weights) {
  double uniform = 0, learned = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    const double square = static_cast<double>(shares[i]) * means[i] * means[i];
    uniform += square;
    learned += square / weights[i];
  }
  return learned > 0 ? static_cast<float>(uniform / learned) : 1;
}

}  // namespace qray
