#include "core/live/live_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/recover/shrink.h"

namespace qray {
namespace {

constexpr float kFewSamples = 4;   // tell no variance by themselves
constexpr float kTotalWeight = 8;  // samples that the noise over all blocks around counts for
constexpr float kLeastLight = 1e-3f;
constexpr float kMostNoise = 16;
constexpr float kManySamples = 32;  // tell a pixel's noise well
constexpr float kSureErrors = 3;    // standard errors

// Of the mean of so many samples. A single one tells none: it may be a rare bright one.
float own_variance(float samples, float mean_square, float luminance) {
  if (samples < 2) return sqr(luminance);
  return std::max(0.0f, mean_square - sqr(luminance)) / (samples - 1);
}

BlockHistory block_of(const ViewBuffer& view, const History& history, int bx, int by) {
  const size_t first = view.index(2 * bx, 2 * by);
  const size_t row = static_cast<size_t>(view.width);
  const size_t pixels[] = {first, first + 1, first + row, first + row + 1};
  BlockHistory block;
  float square = 0;
  // Of another surface, if need be.
  for (const bool any : {false, true}) {
    for (const size_t i : pixels) {
      const PixelHistory& h = history[i];
      if (h.samples == 0 || (!any && !view.features.empty() && !view.same_surface(i, first)))
        continue;
      block.light += h.light * h.samples;
      square += h.square * h.samples;
      block.samples += h.samples;
    }
    if (block.samples > 0) break;
  }
  if (block.samples == 0) return block;
  block.light *= 1 / block.samples;
  block.luminance = luminance(block.light);
  block.variance = square / block.samples;  // for now: the mean square
  if (block.samples >= 2)
    block.own_error = std::sqrt(own_variance(block.samples, block.variance, block.luminance));
  return block;
}

// Of a pixel's light, `guess` being what recovery takes it for. A rare bright sample is noise by
// what its own pixel's samples tell, whatever those around do; a single sample may be one. Where
// all samples around were black, rare bright ones may have been missed.
float standard_error(const PixelHistory& pixel, const BlockHistory& block, float guess) {
  if (block.luminance == 0) return guess * kMostNoise / std::sqrt(pixel.samples);
  const float n = pixel.samples, variance = pixel.variance();
  const float own = own_variance(n, pixel.square, luminance(pixel.light));
  const float with_others = (n * variance + kTotalWeight * block.variance) / (n + kTotalWeight) / n;
  return std::sqrt(std::max(own, with_others));
}

// What recovery is to know of a pixel: of its own samples, or of its block's.
struct Known {
  Rgb light;
  float relative = kMostNoise;  // standard error over the mean, with those around
  float own_error = std::numeric_limits<float>::infinity();

  explicit Known(const BlockHistory& b) : light(b.light), own_error(b.own_error) {
    if (b.samples > 0) relative = std::sqrt(b.variance / b.samples) / (b.luminance + kLeastLight);
  }
  Known(const PixelHistory& h, const BlockHistory& b) : light(h.light) {
    const float n = h.samples;
    const float variance = (n * h.variance() + kTotalWeight * b.variance) / (n + kTotalWeight) / n;
    relative = std::sqrt(variance) / (b.luminance + kLeastLight);
    if (n >= 2) own_error = std::sqrt(own_variance(n, h.square, luminance(h.light)));
  }
};

// Of all pixels (step 1), or of the first of each block (step 2) by all samples of the block.
RecoveryInput known_pixels(const ViewBuffer& view, const History& history, const BlockGrid& blocks,
                           int step, TaskPool& pool) {
  const int width = view.width / step, height = view.height / step;
  RecoveryInput known{Image::unset(width, height, kFeatures), Image::unset(width, height, 3),
                      Image::unset(width, height, 1), Image::unset(width, height, 1)};
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const size_t i = view.index(step * x, step * y);
      const BlockHistory& b = blocks.of_pixel(step * x, step * y);
      const bool own = step == 1 && history[i].samples > 0;
      const Known pixel = own ? Known(history[i], b) : Known(b);
      for (int k = 0; k < kFeatures; ++k)
        known.features.at(x, y, k) = view.features.at(step * x, step * y, k);
      const Rgb albedo = view.albedo(i), light = albedo * pixel.light;
      // Samples of a guided path may be negative (its control variate), as no light is.
      for (int c = 0; c < 3; ++c) known.colour.at(x, y, c) = std::max(0.0f, light[c]);
      const float relative = std::min(pixel.relative, kMostNoise);
      known.noise.at(x, y, 0) = relative / (1 + relative);
      known.own_error.at(x, y, 0) = pixel.own_error * luminance(albedo);
    }
  });
  return known;
}

// Means over the last frames' guesses, of pixels that have some.
void keep_steady(Image& guess, const ViewBuffer& view, History& guesses, TaskPool& pool) {
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      const size_t i = view.index(x, y);
      const Rgb albedo = view.albedo(i);
      PixelHistory& h = guesses[i];
      const float before = std::min(h.guesses, kMostGuesses);
      h.guess = lerp(1 / (1 + before), h.guess, guess.rgb(x, y) / albedo);
      h.guesses = before + 1;
      guess.set_rgb(x, y, h.guess * albedo);
    }
  });
}

}  // namespace

BlockGrid::BlockGrid(const ViewBuffer& view, const History& history, TaskPool& pool)
    : width_(view.width / 2),
      height_(view.height / 2),
      blocks_(static_cast<size_t>(width_) * static_cast<size_t>(height_)) {
  pool.run(static_cast<size_t>(height_), [&](size_t row, int) {
    for (int bx = 0; bx < width_; ++bx)
      blocks_[row * static_cast<size_t>(width_) + static_cast<size_t>(bx)] =
          block_of(view, history, bx, static_cast<int>(row));
  });
  measure_noise(pool);
}

void BlockGrid::measure_noise(TaskPool& pool) {
  constexpr int kRadius = 2;
  const std::vector<BlockHistory> before = blocks_;
  pool.run(static_cast<size_t>(height_), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width_; ++x) {
      float samples = 0, mean = 0, square = 0, own = 0, own_weight = 0, known = 0;
      Rgb light;
      for (int j = std::max(0, y - kRadius); j < std::min(height_, y + kRadius + 1); ++j)
        for (int i = std::max(0, x - kRadius); i < std::min(width_, x + kRadius + 1); ++i) {
          const BlockHistory& b =
              before[static_cast<size_t>(j) * static_cast<size_t>(width_) + static_cast<size_t>(i)];
          if (b.samples == 0) continue;
          known += 1;
          samples += b.samples;
          mean += b.samples * b.luminance;
          square += b.samples * b.variance;
          light += b.light;
          if (b.samples < kFewSamples) continue;
          own += std::max(b.variance - sqr(b.luminance), 0.0f) * b.samples;
          own_weight += b.samples - 1;
        }
      BlockHistory& block = blocks_[row * static_cast<size_t>(width_) + static_cast<size_t>(x)];
      if (samples == 0) continue;
      // A block's own noise leaves out how the light changes from block to block.
      // Few samples that happen to be alike are no certainty: all of them together vouch for it.
      const float total = std::max(square / samples - sqr(mean / samples), 0.0f);
      block.variance = (own + kTotalWeight * total) / (own_weight + kTotalWeight);
      if (block.samples == 0) block.light = light * (1 / known);
      block.luminance = mean / samples;
    }
  });
}

double BlockGrid::noise() const {
  double sum = 0;
  for (const BlockHistory& b : blocks_)
    sum += static_cast<double>(
        std::min(std::sqrt(b.variance / std::max(b.samples, 1.0f)) / (b.luminance + kLeastLight),
                 kMostNoise));
  return sum / static_cast<double>(blocks_.size());
}

Image sampled_picture(const ViewBuffer& view, const History& history, const BlockGrid& blocks,
                      TaskPool& pool) {
  Image picture(view.width, view.height, 3);
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      const size_t i = view.index(x, y);
      const PixelHistory& h = history[i];
      picture.set_rgb(x, y,
                      view.albedo(i) * (h.samples > 0 ? h.light : blocks.of_pixel(x, y).light));
    }
  });
  return picture;
}

Image recovered_picture(const ViewBuffer& view, const History& history, const BlockGrid& blocks,
                        bool knows_pixels, Guess& recovery, History& guesses, TaskPool& pool) {
  const RecoveryInput known = known_pixels(view, history, blocks, knows_pixels ? 1 : 2, pool);
  Image guess =
      knows_pixels ? recovery.of_all(known, pool) : recovery.of_quarter(known, view.features, pool);
  keep_steady(guess, view, guesses, pool);
  Image own(view.width, view.height, 1);
  Image samples(view.width, view.height, 3);
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      const size_t i = view.index(x, y);
      const PixelHistory& h = history[i];
      const BlockHistory& b = blocks.of_pixel(x, y);
      const Rgb albedo = view.albedo(i);
      samples.set_rgb(x, y, h.samples > 0 ? h.light * albedo : guess.rgb(x, y));
      // None: it is the guess already, and tells nothing of how far samples are from it.
      if (h.samples == 0) continue;
      const float scale = std::max(luminance(albedo), kAlbedoFloor);
      own.at(x, y, 0) = scale * standard_error(h, b, luminance(guess.rgb(x, y)) / scale);
    }
  });
  Image picture = shrink_towards(guess, samples, own, pool);
  // A pixel that has many samples knows by itself that it differs: edges, which are few among the
  // pixels around.
  pool.run(static_cast<size_t>(view.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < view.width; ++x) {
      if (history[view.index(x, y)].samples < kManySamples) continue;
      const float distance = sqr(luminance(samples.rgb(x, y)) - luminance(picture.rgb(x, y)));
      const float sure = sqr(kSureErrors * own.at(x, y, 0));
      if (distance > sure)
        picture.set_rgb(x, y, lerp(1 - sure / distance, picture.rgb(x, y), samples.rgb(x, y)));
    }
  });
  return picture;
}

Image enlarged(const Image& picture, int width, int height, TaskPool& pool) {
  if (picture.width() == width && picture.height() == height) return picture;
  Image out(width, height, 3);
  const float step_x = static_cast<float>(picture.width()) / static_cast<float>(width);
  const float step_y = static_cast<float>(picture.height()) / static_cast<float>(height);
  const auto pixel = [&](int x, int y) {
    return picture.rgb(std::clamp(x, 0, picture.width() - 1),
                       std::clamp(y, 0, picture.height() - 1));
  };
  pool.run(static_cast<size_t>(height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const float px = (static_cast<float>(x) + 0.5f) * step_x - 0.5f;
      const float py = (static_cast<float>(y) + 0.5f) * step_y - 0.5f;
      const int x0 = static_cast<int>(std::floor(px)), y0 = static_cast<int>(std::floor(py));
      const float fx = px - static_cast<float>(x0), fy = py - static_cast<float>(y0);
      out.set_rgb(x, y,
                  lerp(fy, lerp(fx, pixel(x0, y0), pixel(x0 + 1, y0)),
                       lerp(fx, pixel(x0, y0 + 1), pixel(x0 + 1, y0 + 1))));
    }
  });
  return out;
}

}  // namespace qray
