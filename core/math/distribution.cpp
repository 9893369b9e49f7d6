#include "core/math/distribution.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray {
namespace {

// Fills cdf (size n + 1, from 0 to 1); returns the sum. A zero sum gives the uniform cdf.
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

// The cell whose interval holds u, and u's position in it.
struct CdfPick {
  int cell;
  float offset;
};
CdfPick pick(std::span<const float> cdf, float u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end(), u);
  const int cell =
      std::clamp(static_cast<int>(above - cdf.begin()) - 1, 0, static_cast<int>(cdf.size()) - 2);
  const float lo = cdf[static_cast<size_t>(cell)], hi = cdf[static_cast<size_t>(cell) + 1];
  const float offset = hi > lo ? (u - lo) / (hi - lo) : 0.5f;
  return {cell, std::clamp(offset, 0.0f, kOneMinusEpsilon)};
}

}  // namespace

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

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const float> weights, int width, int height)
    : width_(width), height_(height), weights_(weights.begin(), weights.end()) {
  QRAY_CHECK(width > 0 && height > 0 &&
             weights.size() == static_cast<size_t>(width) * static_cast<size_t>(height));
  const size_t w = static_cast<size_t>(width), h = static_cast<size_t>(height);
  cell_cdf_.resize(h * (w + 1));
  std::vector<float> rows(h);
  double total = 0;
  for (size_t y = 0; y < h; ++y) {
    const double sum =
        fill_cdf(weights.subspan(y * w, w), std::span(cell_cdf_).subspan(y * (w + 1), w + 1));
    rows[y] = static_cast<float>(sum);
    total += sum;
  }
  row_cdf_.resize(h + 1);
  fill_cdf(rows, row_cdf_);
  const double mean = total / static_cast<double>(w * h);
  for (float& v : weights_) v = mean > 0 ? static_cast<float>(v / mean) : 1.0f;
}

PiecewiseConstant2D::Sample PiecewiseConstant2D::sample(Vec2 u) const {
  const CdfPick row = pick(row_cdf_, u.y);
  const size_t w = static_cast<size_t>(width_), y = static_cast<size_t>(row.cell);
  const CdfPick cell = pick(std::span(cell_cdf_).subspan(y * (w + 1), w + 1), u.x);
  const Vec2 uv{(static_cast<float>(cell.cell) + cell.offset) / static_cast<float>(width_),
                (static_cast<float>(row.cell) + row.offset) / static_cast<float>(height_)};
  return {uv, weights_[y * w + static_cast<size_t>(cell.cell)]};
}

float PiecewiseConstant2D::pdf(Vec2 uv) const {
  const int x = std::clamp(static_cast<int>(uv.x * static_cast<float>(width_)), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(uv.y * static_cast<float>(height_)), 0, height_ - 1);
  return weights_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
}

}  // namespace qray
