#include "core/live/moving_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/film/film.h"
#include "core/math/hash.h"
#include "core/render/pixel_sampler.h"

namespace qray {
namespace {

constexpr int kTileBlocks = Film::kTilePx / 2;
constexpr float kFewBlockSamples = 4;  // of a block: it gets more
constexpr double kMoreForFew = 3;      // times as many
constexpr int kMostPerBlock = 16;
constexpr uint64_t kMovingSeed = 0x6c697665;  // other samples than those of a camera at rest

int tiles_across(int pixels) { return (pixels / 2 + kTileBlocks - 1) / kTileBlocks; }

// A whole number by chance, so that its mean is what was wanted.
int whole(double wanted, uint64_t bits) {
  return static_cast<int>(std::min<double>(wanted, kMostPerBlock) +
                          to_unit_float(static_cast<uint32_t>(bits >> 32)));
}

std::array<size_t, 4> pixels_of_block(const ViewBuffer& view, size_t first) {
  const auto row = static_cast<size_t>(view.width);
  return {first, first + 1, first + row, first + row + 1};
}

float deviation(const ViewBuffer& view, const BlockGrid* blocks, int x, int y) {
  if (!blocks || x / 2 >= blocks->width()) return 0;
  return std::sqrt(blocks->of_pixel(x, y).variance) * luminance(view.albedo(view.index(x, y)));
}

}  // namespace

double MovingSamples::more_for_few() const {
  return settings_.pixels == Pixels::kByNoise ? kMoreForFew : 1;
}

// Where much has just come into view, everything gets less.
double MovingSamples::per_block(const Frame& frame) const {
  const ViewBuffer& view = frame.view;
  const double blocks = view.width * view.height / 4.0;
  double few = 0;
  for (int y = 0; y < view.height; y += 2)
    for (int x = 0; x < view.width; x += 2) {
      float samples = 0;
      for (const size_t i : pixels_of_block(view, view.index(x, y)))
        samples += frame.history[i].samples;
      few += samples < kFewBlockSamples;
    }
  return frame.paths_per_block / (1 + (more_for_few() - 1) * (few / blocks));
}

void MovingSamples::choose_in_block(const Frame& frame, size_t first, double per_block,
                                    std::vector<size_t>& chosen) const {
  const std::array<size_t, 4> pixels = pixels_of_block(frame.view, first);
  if (settings_.pixels == Pixels::kAll) {
    for (const size_t pixel : pixels)
      for (int n = whole(per_block / 4, mix64(frame.number << 32 ^ pixel)); n > 0; --n)
        chosen.push_back(pixel);
    return;
  }
  float has[4], sum = 0;
  for (int k = 0; k < 4; ++k) sum += has[k] = frame.history[pixels[k]].samples;
  const uint64_t bits = mix64(frame.number << 32 ^ first);
  const int count = whole(sum < kFewBlockSamples ? per_block * more_for_few() : per_block, bits);
  for (int n = 0; n < count; ++n) {
    // The pixel that has the fewest; of several, another one each frame.
    int least = static_cast<int>(bits & 3);
    for (int k = 0; k < 4; ++k)
      if (has[k] < has[least]) least = k;
    has[least] += 1;
    chosen.push_back(pixels[least]);
  }
}

// One entry for each sample.
std::vector<size_t> MovingSamples::choose_pixels(const Frame& frame, int tile,
                                                 double per_block) const {
  const ViewBuffer& view = frame.view;
  const int across = tiles_across(view.width);
  const int bx0 = tile % across * kTileBlocks, by0 = tile / across * kTileBlocks;
  const int bx1 = std::min(bx0 + kTileBlocks, view.width / 2);
  const int by1 = std::min(by0 + kTileBlocks, view.height / 2);
  std::vector<size_t> chosen;
  for (int by = by0; by < by1; ++by)
    for (int bx = bx0; bx < bx1; ++bx)
      choose_in_block(frame, view.index(2 * bx, 2 * by), per_block, chosen);
  return chosen;
}

void MovingSamples::sample_tile(const Frame& frame, int tile, double per_block, PathTracer& tracer,
                                GuideDelta* learn) {
  const ViewBuffer& view = frame.view;
  const std::vector<size_t> pixels = choose_pixels(frame, tile, per_block);
  std::vector<Rgb> light(pixels.size());
  PixelSampler sampler(view.camera, settings_.seed ^ kMovingSeed, tracer);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const int x = static_cast<int>(pixels[i] % static_cast<size_t>(view.width));
    const int y = static_cast<int>(pixels[i] / static_cast<size_t>(view.width));
    sampler.sample(x, y, next_sample_[pixels[i]]++, learn, deviation(view, frame.blocks, x, y),
                   {&light[i]});
  }
  tracer.flush();
  for (size_t i = 0; i < pixels.size(); ++i)
    frame.history[pixels[i]].add(light[i] / view.albedo(pixels[i]));
}

void MovingSamples::sample(const Frame& frame, RenderWorkers& workers, TaskPool& pool,
                           const std::stop_token& stop) {
  const double per_block = this->per_block(frame);
  const int tiles = tiles_across(frame.view.width) * tiles_across(frame.view.height);
  const size_t learned_of = frame.guide.few ? GuidedPixels::kFew : 1;  // tiles, one in so many
  updates_.start(0);
  pool.run(static_cast<size_t>(tiles), [&](size_t tile, int worker) {
    if (stop.stop_requested()) return;
    std::unique_ptr<GuideDelta> learned;
    if (frame.guide.learns(static_cast<int>(tile), 0)) learned = updates_.empty_delta();
    sample_tile(frame, static_cast<int>(tile), per_block, workers[worker].tracer, learned.get());
    if (learned) updates_.finish(tile / learned_of, std::move(learned));
  });
}

}  // namespace qray
