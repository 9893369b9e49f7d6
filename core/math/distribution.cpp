#include "core/math/distribution.h"

#include <algorithm>

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

CdfPick pick_by_cdf(std::span<const float> cdf, float u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end(), u);
  const int index =
      std::clamp(static_cast<int>(above - cdf.begin()) - 1, 0, static_cast<int>(cdf.size()) - 2);
  const float lo = cdf[static_cast<size_t>(index)], hi = cdf[static_cast<size_t>(index) + 1];
  const float offset = hi > lo ? (u - lo) / (hi - lo) : 0.5f;
  return {index, std::clamp(offset, 0.0f, kOneMinusEpsilon)};
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
