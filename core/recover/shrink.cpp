#include "core/recover/shrink.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/recover/surroundings.h"

namespace qray {
namespace {

constexpr int kWindowPx = 3;
constexpr int kWindowBandRows = 16;
constexpr float kAccident = 0.01f;    // less: that a window missed light is no accident
constexpr float kFewPixelsDoubt = 3;  // times the variance of what pixels around tell
constexpr float kModest = 0.5f;       // what few pixels may tell each
constexpr float kLeastGuess = 1e-3f;  // luminance: differences are relative to the guess

// Of each pixel of some rows, one after the other: squares over the guess'.
struct PixelRows {
  std::vector<float> distance, noise, missing;  // the last: luminance that the samples have not

  explicit PixelRows(size_t count) : distance(count), noise(count), missing(count) {}
};

// Sums over the pixels around each of a row. Of distance less noise, what is left: each pixel's up
// to kModest, and its square.
struct WindowRow {
  std::vector<float> distance, noise, missing, modest, square;

  explicit WindowRow(size_t count)
      : distance(count), noise(count), missing(count), modest(count), square(count) {}
};

// Sums of 2 x radius + 1 values beside each other, fewer at the row's ends.
void sum_beside(std::vector<float>& row, std::vector<float>& sums) {
  const size_t radius = kWindowPx, width = row.size();
  sums = row;
  for (size_t shift = 1; shift <= std::min(radius, width - 1); ++shift) {
    for (size_t x = 0; x + shift < width; ++x) sums[x] += row[x + shift];
    for (size_t x = shift; x < width; ++x) sums[x] += row[x - shift];
  }
  std::swap(row, sums);
}

}  // namespace

Image shrink_towards(const Image& guess, const Image& samples, const Image& own_error,
                     TaskPool& pool) {
  const int width = guess.width(), height = guess.height();
  const Surroundings around(samples, own_error, pool);
  Image out = Image::unset(width, height, 3);
  pool.run(static_cast<size_t>((height + kWindowBandRows - 1) / kWindowBandRows), [&](size_t band,
                                                                                      int) {
    const int top = static_cast<int>(band) * kWindowBandRows,
              end = std::min(height, top + kWindowBandRows);
    const int first = std::max(0, top - kWindowPx), last = std::min(height, end + kWindowPx);
    const auto row = [&](int y) {
      return static_cast<size_t>(y - first) * static_cast<size_t>(width);
    };
    PixelRows pixels(row(last));
    for (int y = first; y < last; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t i = row(y) + static_cast<size_t>(x);
        const float g = luminance(guess.rgb(x, y)), missing = g - luminance(samples.rgb(x, y));
        const float scale = 1 / (sqr(g) + sqr(kLeastGuess));
        pixels.distance[i] = sqr(missing) * scale;
        pixels.noise[i] = sqr(own_error.at(x, y, 0)) * scale;
        pixels.missing[i] = missing;
      }
    std::vector<float> buffer;
    for (int y = top; y < end; ++y) {
      const int above = std::max(first, y - kWindowPx), below = std::min(last, y + kWindowPx + 1);
      WindowRow windows(static_cast<size_t>(width));
      for (int j = above; j < below; ++j)
        for (size_t x = 0, i = row(j); x < static_cast<size_t>(width); ++x, ++i) {
          windows.distance[x] += pixels.distance[i];
          windows.noise[x] += pixels.noise[i];
          windows.missing[x] += pixels.missing[i];
          const float left = pixels.distance[i] - pixels.noise[i];
          windows.modest[x] += std::min(left, kModest);
          windows.square[x] += sqr(left);
        }
      for (std::vector<float>* sums :
           {&windows.distance, &windows.noise, &windows.missing, &windows.modest, &windows.square})
        sum_beside(*sums, buffer);
      for (int x = 0; x < width; ++x) {
        const size_t i = static_cast<size_t>(x);
        const int beside = std::min(width, x + kWindowPx + 1) - std::max(0, x - kWindowPx);
        const float count = static_cast<float>((below - above) * beside), over = 1 / count;
        const float seen_noise = windows.noise[i] * over;
        float noise = seen_noise;
        // Light that the guess has and these pixels have not met may only be rare: their noise is
        // that of the hits that they missed, as far as it is no small chance that all missed
        // them.
        const float missing = windows.missing[i] * over;
        const float hit = missing > 0 ? luminance(around.light_of_a_hit(x, y)) : 0.0f;
        if (hit > 0) {
          const float chance = std::exp(-missing * count / hit);
          noise = std::max(noise, std::min(1.0f, chance / kAccident) * missing * hit /
                                      (sqr(luminance(guess.rgb(x, y))) + sqr(kLeastGuess)));
        }
        // That few pixels tell much is no evidence: bright samples may be in both of their halves.
        const float left = windows.distance[i] - noise * count;
        const float modest = windows.modest[i] - (noise - seen_noise) * count;
        const float sure = std::max(0.0f, 1 - kFewPixelsDoubt * windows.square[i] / sqr(left));
        const float prior =
            left > 0 ? lerp(sure, std::clamp(modest, 0.0f, left), left) * over : 0.0f;
        // A pixel with more noise than its neighbours, such as a firefly, counts its own.
        const float own = pixels.noise[row(y) + i];
        const float share = prior > 0 ? prior / (prior + std::max(noise, own)) : 0.0f;
        out.set_rgb(x, y, lerp(share, guess.rgb(x, y), samples.rgb(x, y)));
      }
    }
  });
  return out;
}

}  // namespace qray
