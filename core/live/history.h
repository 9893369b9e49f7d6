// What earlier frames' samples say of a frame's pixels: carried over by where each pixel's surface
// was seen before (reverse reprojection: Nehab et al. 2007; moments as in SVGF, Schied et al.
// 2017), left behind where another surface was seen. Any thread; the pool's work.
#pragma once

#include <vector>

#include "core/live/view_buffer.h"

namespace qray {

// Means of a pixel's samples, as light over albedo: surfaces' patterns do not blur as they move.
struct PixelHistory {
  Rgb light;
  float square = 0;   // of the light's luminance
  float samples = 0;  // that are in it, 0: nothing is known
  // What recovery made of it, over albedo: a mean over so many frames, 0: not known.
  Rgb guess{};
  float guesses = 0;

  void add(Rgb sample);
  float variance() const;  // of a sample's luminance; rough while samples are few
};

using History = std::vector<PixelHistory>;  // by ViewBuffer::index()

// Samples that a mean may claim after it has moved: what comes counts the more, and light that
// changes with the direction it is seen from is soon that of now.
constexpr float kMostMovedSamples = 48, kMostGlossySamples = 6;
// Frames whose guesses a mean may claim: single ones flicker where light is rare.
constexpr float kMostGuesses = 4;

History reproject(const ViewBuffer& before, const History& history, const ViewBuffer& now,
                  TaskPool& pool);

}  // namespace qray
