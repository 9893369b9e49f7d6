#include "core/recover/sample_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace qray {
namespace {

constexpr int kRangePx = 3;
constexpr int kRangeBandRows = 16;
constexpr float kMostMissed = 4.6f;  // hits: of so many none is seen by a chance of 1 %
constexpr float kTouch = 1e-4f;      // relative: less is rounding

// The least and the largest of 2 x radius + 1 pixels beside each other, at a row's ends of fewer.
void row_extremes(const float* row, size_t count, int radius, std::vector<float>& padded,
                  float* least, float* largest) {
  const size_t edge = 3 * static_cast<size_t>(radius);
  padded.resize(count + 2 * edge);
  std::copy(row, row + count, &padded[edge]);
  for (size_t i = 0; i < edge; ++i) {
    padded[i] = row[i % 3];
    padded[edge + count + i] = row[count - 3 + i % 3];
  }
  std::copy(row, row + count, least);
  std::copy(row, row + count, largest);
  for (size_t shift = 0; shift <= 2 * edge; shift += 3)
    for (size_t i = 0; i < count; ++i) {
      least[i] = std::min(least[i], padded[i + shift]);
      largest[i] = std::max(largest[i], padded[i + shift]);
    }
}

bool is_within(Rgb c, Rgb low, Rgb high) {
  return c.r >= low.r && c.g >= low.g && c.b >= low.b && c.r <= high.r && c.g <= high.g &&
         c.b <= high.b;
}

Rgb least_of(Rgb a, Rgb b) { return {std::min(a.r, b.r), std::min(a.g, b.g), std::min(a.b, b.b)}; }
Rgb largest_of(Rgb a, Rgb b) {
  return {std::max(a.r, b.r), std::max(a.g, b.g), std::max(a.b, b.b)};
}

}  // namespace

SampleRange::SampleRange(const Image& samples, const Image& own_error, int step, TaskPool& pool)
    : step_(step),
      radius_(kRangePx / step),
      least_(Image::unset(samples.width(), samples.height(), 3)),
      largest_(Image::unset(samples.width(), samples.height(), 3)),
      around_(samples, own_error, pool) {
  const int height = samples.height();
  const size_t count = 3 * static_cast<size_t>(samples.width());
  pool.run(static_cast<size_t>((height + kRangeBandRows - 1) / kRangeBandRows),
           [&](size_t band, int) {
             const int top = static_cast<int>(band) * kRangeBandRows,
                       end = std::min(height, top + kRangeBandRows);
             const int first = std::max(0, top - radius_), last = std::min(height, end + radius_);
             std::vector<float> padded, least(count * static_cast<size_t>(last - first)),
                 largest(least.size());
             const auto at = [&](int y) { return count * static_cast<size_t>(y - first); };
             for (int y = first; y < last; ++y)
               row_extremes(&samples.data()[count * static_cast<size_t>(y)], count, radius_, padded,
                            &least[at(y)], &largest[at(y)]);
             for (int y = top; y < end; ++y) {
               float *low = &least_.data()[count * static_cast<size_t>(y)],
                     *high = &largest_.data()[count * static_cast<size_t>(y)];
               std::copy_n(&least[at(y)], count, low);
               std::copy_n(&largest[at(y)], count, high);
               for (int j = std::max(0, y - radius_); j < std::min(height, y + radius_ + 1); ++j) {
                 const float *l = &least[at(j)], *h = &largest[at(j)];
                 for (size_t i = 0; i < count; ++i) {
                   low[i] = std::min(low[i], l[i]);
                   high[i] = std::max(high[i], h[i]);
                 }
               }
             }
           });
}

Rgb SampleRange::may_be_missed(int x, int y) const {
  const auto beside = [this](int at, int count) {
    return std::min(count, at + radius_ + 1) - std::max(0, at - radius_);
  };
  const int count = beside(x, least_.width()) * beside(y, least_.height());
  return around_.light_of_a_hit(x, y) * (kMostMissed / static_cast<float>(count));
}

uint64_t SampleRange::hold_row(Image& picture, int y) const {
  uint64_t held = 0;
  for (int x = 0; x < picture.width(); ++x) {
    const Rgb was = picture.rgb(x, y);
    if (is_within(was, least_.rgb(x / step_, y / step_), largest_.rgb(x / step_, y / step_)))
      continue;
    Rgb low = least_.rgb(x / step_, y / step_);
    Rgb high = largest_of(largest_.rgb(x / step_, y / step_), may_be_missed(x / step_, y / step_));
    // Pixels between two samples have one more of them within their reach.
    const int last_x = std::min(x / step_ + x % step_, least_.width() - 1),
              last_y = std::min(y / step_ + y % step_, least_.height() - 1);
    for (int j = y / step_; j <= last_y; ++j)
      for (int i = x / step_; i <= last_x; ++i) {
        low = least_of(low, least_.rgb(i, j));
        high = largest_of(high, largest_.rgb(i, j));
      }
    bool is_out = false;
    Rgb now;
    for (int c = 0; c < 3; ++c) {
      now[c] = std::clamp(was[c], low[c], high[c]);
      is_out |= std::abs(now[c] - was[c]) > kTouch * std::max(now[c], was[c]);
    }
    picture.set_rgb(x, y, now);
    held += is_out;
  }
  return held;
}

}  // namespace qray
