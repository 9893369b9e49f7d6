#include "core/live/live_picture.h"

#include <algorithm>
#include <cmath>

#include "core/recover/shrink.h"

namespace qray {
namespace {

constexpr float kFewSamples = 4;   // tell no variance by themselves
constexpr float kTotalWeight = 8;  // samples that the noise over all blocks around counts for
constexpr float kLeastLight = 1e-3f;
constexpr float kMostNoise = 16;
constexpr float kManySamples = 32;  // tell a pixel's noise well
constexpr float kSureErrors = 3;    // standard errors

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
  return block;
}

// Of a pixel's light, `guess` being what recovery takes it for. A rare bright sample is noise by
// what its own pixel's samples tell, whatever those around do; a single sample may be one. Where
// all samples around were black, rare bright ones may have been missed.
float standard_error(const PixelHistory& pixel, const BlockHistory& block, float guess) {
  if (block.luminance == 0) return guess * kMostNoise / std::sqrt(pixel.samples);
  const float n = pixel.samples, variance = pixel.variance();
  const float own = n < 2 ? sqr(luminance(pixel.light)) : variance / (n - 1);
  const float with_others = (n * variance + kTotalWeight * block.variance) / (n + kTotalWeight) / n;
  return std::sqrt(std::max(own, with_others));
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
                        FastRecovery& recovery, TaskPool& pool) {
  Image known(view.width, view.height, 3), noise(view.width, view.height, 1), own = noise;
  pool.run(static_cast<size_t>(view.height / 2), [&](size_t row, int) {
    const int y = static_cast<int>(row) * 2;
    for (int x = 0; x < view.width; x += 2) {
      const BlockHistory& b = blocks.of_pixel(x, y);
      known.set_rgb(x, y, view.albedo(view.index(x, y)) * b.light);
      const float relative =
          b.samples > 0 ? std::min(std::sqrt(b.variance / b.samples) / (b.luminance + kLeastLight),
                                   kMostNoise)
                        : kMostNoise;
      noise.at(x, y, 0) = relative / (1 + relative);
    }
  });
  const Image guess = recovery.run(view.features, known, noise, pool);
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
