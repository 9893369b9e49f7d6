#include "core/recover/brightness.h"

#include <algorithm>
#include <vector>

#include "core/recover/energy.h"

namespace qray {
namespace {

constexpr size_t kClasses = 8;
constexpr size_t kAsked = 1 << 15;  // pixels, at least, that tell where classes end
constexpr double kClassDoubt = 2;   // times the variance: the guess chose the class by the samples

struct Class {
  Energy energy;
  double luminance = 0, count = 0;
  float middle() const { return static_cast<float>(luminance / std::max(count, 1.0)); }
};
using Classes = std::array<Class, kClasses>;
using Bounds = std::array<float, kClasses - 1>;

Bounds bounds_of(const Image& guess, int step) {
  const size_t width = static_cast<size_t>(guess.width()),
               pixels = width * static_cast<size_t>(guess.height());
  // Odd, so that columns differ from row to row.
  const size_t stride = pixels / kAsked | 1;
  std::vector<float> asked;
  for (size_t i = 0; i < pixels; i += stride) {
    const int x = static_cast<int>(i % width) / step * step,
              y = static_cast<int>(i / width) / step * step;
    asked.push_back(luminance(guess.rgb(x, y)));
  }
  std::ranges::sort(asked);
  Bounds bounds;
  for (size_t k = 1; k < kClasses; ++k) bounds[k - 1] = asked[k * asked.size() / kClasses];
  return bounds;
}

Classes classes_of(const Image& guess, const Image& samples, int step, TaskPool& pool) {
  const Bounds bounds = bounds_of(guess, step);
  std::vector<Classes> rows(static_cast<size_t>((guess.height() + step - 1) / step));
  pool.run(rows.size(), [&](size_t row, int) {
    const int y = static_cast<int>(row) * step;
    for (int x = 0; x < guess.width(); x += step) {
      const Rgb g = guess.rgb(x, y);
      const float l = luminance(g);
      Class& of =
          rows[row][static_cast<size_t>(std::ranges::upper_bound(bounds, l) - bounds.begin())];
      of.energy.add(samples.rgb(x, y), g);
      of.luminance += static_cast<double>(l), ++of.count;
    }
  });
  Classes sum{};
  for (const Classes& row : rows)
    for (size_t k = 0; k < kClasses; ++k) {
      sum[k].energy += row[k].energy;
      sum[k].luminance += row[k].luminance, sum[k].count += row[k].count;
    }
  for (Class& c : sum)
    c.energy.set_factor(c.energy.wanted(c.energy.guess, kClassDoubt * c.energy.square), Rgb{1});
  return sum;
}

}  // namespace

void balance_by_brightness(Image& guess, const Image& samples, int step, TaskPool& pool) {
  const Classes classes = classes_of(guess, samples, step, pool);
  if (std::ranges::all_of(classes, [](const Class& c) { return c.energy.is_as_it_should_be(); }))
    return;
  std::array<float, kClasses> middles;
  for (size_t k = 0; k < kClasses; ++k)
    middles[k] = std::max(classes[k].middle(), k > 0 ? middles[k - 1] : 0.0f);
  pool.run(static_cast<size_t>(guess.height()), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < guess.width(); ++x) {
      const Rgb g = guess.rgb(x, y);
      const float l = luminance(g);
      const auto above =
          static_cast<size_t>(std::ranges::upper_bound(middles, l) - middles.begin());
      const size_t high = std::min(above, kClasses - 1), low = above == 0 ? 0 : above - 1;
      const float between = middles[high] - middles[low];
      const float t = between > 0 ? (l - middles[low]) / between : 0.0f;
      guess.set_rgb(x, y, g * lerp(t, classes[low].energy.factor, classes[high].energy.factor));
    }
  });
}

}  // namespace qray
