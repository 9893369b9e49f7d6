#include "core/recover/shrink.h"

#include <algorithm>
#include <cmath>

#include "core/recover/box_mean.h"

namespace qray {
namespace {

constexpr int kRadiusPx = 3;
constexpr int kFartherPx = 15;        // where light is met that these few pixels may have missed
constexpr float kAccident = 0.01f;    // less: that they missed it is no accident
constexpr float kLeastGuess = 1e-3f;  // luminance: differences are relative to the guess

// Squares over the guess': summed over a column of the window, or the whole.
struct Squares {
  float distance = 0, noise = 0;
  float missing = 0;  // luminance of the guess that the samples have not
  float largest = 0;  // of one pixel, of its distance over its noise
  void operator+=(Squares s) {
    distance += s.distance;
    noise += s.noise;
    missing += s.missing;
    largest = std::max(largest, s.largest);
  }
};

// Variance over mean of the samples around: how bright what makes their noise is.
std::vector<float> noisy_brightness(const Image& samples, const Image& own_error, TaskPool& pool) {
  Image sums = Image::unset(samples.width(), samples.height(), 3);
  pool.run(static_cast<size_t>(sums.height()), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < sums.width(); ++x) {
      const float own = own_error.at(x, y, 0);
      sums.set_rgb(x, y, {luminance(samples.rgb(x, y)), std::isfinite(own) ? sqr(own) : 0.0f, 0});
    }
  });
  const Image means = box_mean(sums, kFartherPx, 1, pool);
  std::vector<float> out(means.data().size() / 3);
  for (size_t i = 0; i < out.size(); ++i) {
    const float* mean = &means.data()[3 * i];
    out[i] = mean[0] > 0 ? mean[1] / mean[0] : 0.0f;
  }
  return out;
}

}  // namespace

Image shrink_towards(const Image& guess, const Image& samples, const Image& own_error,
                     TaskPool& pool) {
  const int width = guess.width(), height = guess.height();
  std::vector<Squares> squares(static_cast<size_t>(width) * static_cast<size_t>(height));
  const auto at = [&](int x, int y) -> Squares& {
    return squares[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const float g = luminance(guess.rgb(x, y));
      const float scale = 1 / (sqr(g) + sqr(kLeastGuess));
      const float distance = sqr(luminance(samples.rgb(x, y)) - g) * scale,
                  noise = sqr(own_error.at(x, y, 0)) * scale;
      at(x, y) = {distance, noise, g - luminance(samples.rgb(x, y)), distance - noise};
    }
  });
  const std::vector<float> brightness = noisy_brightness(samples, own_error, pool);
  Image out = Image::unset(width, height, 3);
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    const int top = std::max(0, y - kRadiusPx), bottom = std::min(height, y + kRadiusPx + 1);
    std::vector<Squares> columns(static_cast<size_t>(width));
    for (int j = top; j < bottom; ++j)
      for (int x = 0; x < width; ++x) columns[static_cast<size_t>(x)] += at(x, j);
    for (int x = 0; x < width; ++x) {
      const int left = std::max(0, x - kRadiusPx), right = std::min(width, x + kRadiusPx + 1);
      Squares sum;
      for (int i = left; i < right; ++i) sum += columns[static_cast<size_t>(i)];
      const float over = 1 / static_cast<float>((bottom - top) * (right - left));
      // Light that the guess has and these pixels have not met may only be rare: their noise is
      // that of the wider surroundings, as far as it is no small chance that all of them missed it.
      const float missing = std::max(0.0f, sum.missing * over);
      const float bright =
          brightness[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
      const float chance = bright > 0 ? std::exp(-missing / (bright * over)) : 0.0f;
      const float unseen = std::min(1.0f, chance / kAccident) * missing * bright /
                           (sqr(luminance(guess.rgb(x, y))) + sqr(kLeastGuess));
      const float noise = std::max(sum.noise * over, unseen);
      // One pixel alone is no evidence: bright samples may be in both of its halves.
      const float largest = std::max(sum.largest, 0.0f);
      const float others = sum.distance - noise / over - largest;
      const float prior = others > 0 ? (others + std::min(largest, others)) * over : 0.0f;
      // A pixel with more noise than its neighbours, such as a firefly, counts its own.
      const float share = prior > 0 ? prior / (prior + std::max(noise, at(x, y).noise)) : 0.0f;
      out.set_rgb(x, y, lerp(share, guess.rgb(x, y), samples.rgb(x, y)));
    }
  });
  return out;
}

}  // namespace qray
