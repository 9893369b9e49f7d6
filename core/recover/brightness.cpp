#include "core/recover/brightness.h"

#include <algorithm>
#include <vector>

namespace qray {
namespace {

constexpr size_t kAsked = 1 << 12;  // pixels, at least, that tell where classes end
constexpr double kClassDoubt = 2;   // times the variance: the guess chose the class by the samples

// How many of the bounds, in order, a value is not below.
template <size_t kCount>
size_t class_of(const std::array<float, kCount>& bounds, float value) {
  size_t k = 0;
  for (const float bound : bounds) k += value >= bound;
  return k;
}

}  // namespace

BrightnessClasses::BrightnessClasses(const Image& guess, int step) {
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
  for (size_t k = 1; k < kClasses; ++k) bounds_[k - 1] = asked[k * asked.size() / kClasses];
}

void BrightnessClasses::add_row(const float* samples, const float* guess, int width,
                                Sums& sums) const {
  for (int x = 0; x < width; ++x, samples += 3, guess += 3) {
    const Rgb g{guess[0], guess[1], guess[2]};
    const float l = luminance(g);
    Sum& of = sums[class_of(bounds_, l)];
    of.energy.add({samples[0], samples[1], samples[2]}, g);
    of.luminance += static_cast<double>(l), ++of.count;
  }
}

bool BrightnessClasses::set_factors(std::span<const Sums> parts) {
  bool all_are = true;
  for (size_t k = 0; k < kClasses; ++k) {
    Sum sum;
    for (const Sums& part : parts) {
      sum.energy += part[k].energy;
      sum.luminance += part[k].luminance, sum.count += part[k].count;
    }
    Energy& energy = sum.energy;
    energy.set_factor(energy.wanted(energy.guess, kClassDoubt * energy.square), Rgb{1});
    all_are &= energy.is_as_it_should_be();
    factors_[k] = energy.factor;
    const auto middle = static_cast<float>(sum.luminance / std::max(sum.count, 1.0));
    middles_[k] = std::max(middle, k > 0 ? middles_[k - 1] : 0.0f);
  }
  return !all_are;
}

void BrightnessClasses::multiply_row(float* picture, int width) const {
  for (int x = 0; x < width; ++x, picture += 3) {
    const float l = luminance(Rgb{picture[0], picture[1], picture[2]});
    const size_t above = class_of(middles_, l);
    const size_t high = std::min(above, kClasses - 1), low = above == 0 ? 0 : above - 1;
    const float between = middles_[high] - middles_[low];
    const float t = between > 0 ? (l - middles_[low]) / between : 0.0f;
    const Rgb factor = lerp(t, factors_[low], factors_[high]);
    for (int c = 0; c < 3; ++c) picture[c] *= factor[c];
  }
}

}  // namespace qray
