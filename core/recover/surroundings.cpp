#include "core/recover/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qray {
namespace {

constexpr int kCellPx = 8;

constexpr float kNoAccident = 0.01f;  // less: that no sample was lit is no accident

struct CellLight {
  Rgb light;
  float variance = 0;  // of the luminance
  float samples = 0;
  void operator+=(const CellLight& c) {
    light += c.light, variance += c.variance, samples += c.samples;
  }
  bool is_black() const { return luminance(light) <= 0; }
  Rgb of_a_hit() const { return light * (variance / sqr(luminance(light))); }
};

CellLight sample_light(const Image& samples, const Image& own_error, int x, int y) {
  const Rgb light = samples.rgb(x, y);
  const float own = own_error.at(x, y, 0);
  if (std::isfinite(own)) return {light, sqr(own), 1};
  // An edge is on one side alone.
  float least = std::numeric_limits<float>::infinity();
  for (const int beside : {x - 1, x + 1})
    if (beside >= 0 && beside < samples.width())
      least = std::min(least, sqr(luminance(light) - luminance(samples.rgb(beside, y))));
  return {light, std::isfinite(least) ? least : 0, 1};
}

}  // namespace

Surroundings::Surroundings(const Image& samples, const Image& own_error, TaskPool& pool)
    : width_((samples.width() + kCellPx - 1) / kCellPx),
      height_((samples.height() + kCellPx - 1) / kCellPx),
      hits_(static_cast<size_t>(width_) * static_cast<size_t>(height_)) {
  std::vector<CellLight> cells(hits_.size());
  const auto index = [this](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  };
  pool.run(static_cast<size_t>(height_), [&](size_t row, int) {
    const int cy = static_cast<int>(row);
    for (int y = cy * kCellPx; y < std::min(samples.height(), (cy + 1) * kCellPx); ++y)
      for (int x = 0; x < samples.width(); ++x)
        cells[index(x / kCellPx, cy)] += sample_light(samples, own_error, x, y);
  });
  CellLight whole;
  for (const CellLight& cell : cells) whole += cell;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      CellLight sum;
      for (int j = std::max(0, y - 1); j < std::min(height_, y + 2); ++j)
        for (int i = std::max(0, x - 1); i < std::min(width_, x + 2); ++i)
          sum += cells[index(i, j)];
      Rgb& hit = hits_[index(x, y)];
      if (!sum.is_black()) {
        hit = sum.of_a_hit();
      } else if (!whole.is_black()) {
        const Rgb elsewhere = whole.of_a_hit();
        const float expected =
            sum.samples / whole.samples * luminance(whole.light) / luminance(elsewhere);
        hit = elsewhere * std::min(1.0f, std::exp(-expected) / kNoAccident);
      }
    }
}

Rgb Surroundings::light_of_a_hit(int x, int y) const {
  // Between the centres of four cells.
  const auto place = [](int pixel, int count, int& first) {
    const float at = (static_cast<float>(pixel) + 0.5f) / kCellPx - 0.5f;
    first = std::clamp(static_cast<int>(std::floor(at)), 0, std::max(0, count - 2));
    return std::clamp(at - static_cast<float>(first), 0.0f, 1.0f);
  };
  int x0, y0;
  const float fx = place(x, width_, x0), fy = place(y, height_, y0);
  const Rgb* top = &hits_[static_cast<size_t>(y0) * static_cast<size_t>(width_)];
  const Rgb* bottom = height_ > 1 ? top + width_ : top;
  const int x1 = std::min(x0 + 1, width_ - 1);
  return lerp(fy, lerp(fx, top[x0], top[x1]), lerp(fx, bottom[x0], bottom[x1]));
}

}  // namespace qray
