#include "core/math/distribution.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"

namespace qray {

double fill_cdf(std::span<const float> weights, std::span<float> cdf) {
  double sum = 0;
  for (float w : weights) sum += w;
  double running = 0;
  cdf[0] = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    running += sum > 0 ? weights[i] / sum : 1.0 / static_cast<double>(weights.size());
    cdf[i + 1] = static_cast<float>(running);
  }
  cdf[weights.size()] = 1;
  return sum;
}

void fill_guide(std::span<const float> cdf, std::span<uint32_t> guide) {
  const size_t parts = guide.size() - 1, last = cdf.size() - 2;
  QRAY_CHECK(std::has_single_bit(parts));  // u times it is exact
  size_t index = 0;
  for (size_t k = 0; k <= parts; ++k) {
    const float u = static_cast<float>(k) / static_cast<float>(parts);
    while (index < last && cdf[index + 1] <= u) ++index;
    guide[k] = static_cast<uint32_t>(index);
  }
}

CdfPick pick_by_cdf(std::span<const float> cdf, std::span<const uint32_t> guide, float u) {
  const size_t parts = guide.size() - 1;
  const size_t part = std::min(static_cast<size_t>(u * static_cast<float>(parts)), parts - 1);
  // The last of them that begins at u or before, without branches: nothing could predict them.
  const float* at = cdf.data() + guide[part];
  for (size_t count = guide[part + 1] - guide[part] + 1; count > 1;) {
    const size_t half = count / 2;
    at += half & -static_cast<size_t>(at[half] <= u);
    count -= half;
  }
  const float lo = at[0], hi = at[1];
  const float offset = hi > lo ? (u - lo) / (hi - lo) : 0.5f;
  return {static_cast<int>(at - cdf.data()), std::clamp(offset, 0.0f, kOneMinusEpsilon)};
}

AliasTable::AliasTable(std::span<const float> weights) : bins_(weights.size()) {
  const size_t n = weights.size();
  QRAY_CHECK(n > 0);
  double sum = 0;
  for (float w : weights) sum += w;
  std::vector<double> scaled(n);
  std::vector<uint32_t> under, over;
  for (size_t i = 0; i < n; ++i) {
    const double p = sum > 0 ? weights[i] / sum : 1.0 / static_cast<double>(n);
    bins_[i].probability = static_cast<float>(p);
    bins_[i].alias = static_cast<uint32_t>(i);
    scaled[i] = p * static_cast<double>(n);
    (scaled[i] < 1 ? under : over).push_back(static_cast<uint32_t>(i));
  }
  while (!under.empty() && !over.empty()) {
    const uint32_t small = under.back(), large = over.back();
    under.pop_back();
    bins_[small].keep = static_cast<float>(scaled[small]);
    bins_[small].alias = large;
    scaled[large] -= 1 - scaled[small];
    if (scaled[large] < 1) {
      over.pop_back();
      under.push_back(large);
    }
  }
}

}  // namespace qray
