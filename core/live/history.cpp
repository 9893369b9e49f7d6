#include "core/live/history.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

constexpr float kMostPixelsOff = 2;        // from the plane through what is seen
constexpr float kMirroredDistance = .05f;  // relative, of what is seen in mirrors
constexpr float kNearer = 0.9f;            // than where it was seen from: little is lost there
constexpr float kLeastWeight = 0.05f;      // of the taps that saw it
constexpr float kDiffuseKind = 0, kMixedKind = 0.5f;

struct Reprojection {
  const ViewBuffer& before;
  const History& history;
  const ViewBuffer& now;

  // What a pixel shows now, as it was before.
  struct Sought {
    uint32_t surface;
    Vec3 p, n;       // n: 0 of the environment
    float distance;  // metres, from where it was seen before
    float most_off;  // metres
  };
  Sought sought(size_t i) const {
    const Vec3 p = now.points[i];
    const float distance = before.camera.distance(p);
    return {now.surfaces[i], p, now.normal(i), distance,
            now.surfaces[i] >> kMirrorShift ? kMirroredDistance * distance
                                            : kMostPixelsOff * before.camera.cone().at(distance)};
  }
  bool shows(size_t tap, const Sought& s) const {
    if (before.surfaces[tap] != s.surface) return false;
    if (dot(s.n, s.n) == 0) return true;
    if (dot(s.n, before.normal(tap)) < ViewBuffer::kLeastCosine) return false;
    const Vec3 p = before.points[tap];
    return std::abs(s.surface >> kMirrorShift ? before.camera.distance(p) - s.distance
                                              : dot(s.n, p - s.p)) < s.most_off;
  }

  PixelHistory pixel(size_t i) const {
    const Vec3 p = now.points[i];
    const std::optional<Vec2> at = before.camera.project(p);
    if (!at || !(at->x > -1 && at->y > -1 && at->x < static_cast<float>(before.width) + 1 &&
                 at->y < static_cast<float>(before.height) + 1))
      return {};
    const Sought what = sought(i);
    const float x0 = std::floor(at->x - 0.5f), y0 = std::floor(at->y - 0.5f);
    const float fx = at->x - 0.5f - x0, fy = at->y - 0.5f - y0;
    PixelHistory sum;
    float weights = 0, seen = 0, guessed = 0;
    for (int k = 0; k < 4; ++k) {
      const int dx = k & 1, dy = k >> 1;
      const int x = static_cast<int>(x0) + dx, y = static_cast<int>(y0) + dy;
      const float weight = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
      if (weight == 0 || x < 0 || y < 0 || x >= before.width || y >= before.height) continue;
      const size_t tap = before.index(x, y);
      if (!shows(tap, what)) continue;
      seen += weight;
      const PixelHistory& h = history[tap];
      if (h.guesses > 0) {
        sum.guess += h.guess * weight;
        sum.guesses += h.guesses * weight;
        guessed += weight;
      }
      if (h.samples == 0) continue;
      // By the samples in them too: a mean of many is surer than its neighbour of one.
      const float sure = weight * h.samples;
      sum.light += h.light * sure;
      sum.square += h.square * sure;
      sum.samples += weight * h.samples;
      weights += sure;
    }
    if (seen < kLeastWeight) return {};
    if (guessed > 0) sum.guess *= 1 / guessed, sum.guesses /= guessed;
    if (weights == 0) return sum;
    sum.light *= 1 / weights;
    sum.square /= weights;
    // What was seen from farther away, in fewer pixels, is surer of less.
    const float ratio = now.camera.cone().at(now.camera.distance(p)) /
                        std::max(before.camera.cone().at(what.distance), 1e-20f);
    const float kind = now.kind(i);
    const bool glossy =
        what.surface != Seen{}.surface &&
        ((kind > kDiffuseKind && kind <= kMixedKind) || what.surface >> kMirrorShift);
    sum.samples = std::min(sum.samples / seen * (ratio > kNearer ? 1 : ratio * ratio),
                           glossy ? kMostGlossySamples : kMostMovedSamples);
    return sum;
  }
};

}  // namespace

void PixelHistory::add(Rgb sample) {
  samples += 1;
  const float share = 1 / samples;
  light = lerp(share, light, sample);
  square = lerp(share, square, sqr(luminance(sample)));
}

float PixelHistory::variance() const { return std::max(square - sqr(luminance(light)), 0.0f); }

History reproject(const ViewBuffer& before, const History& history, const ViewBuffer& now,
                  TaskPool& pool) {
  History moved(now.points.size());
  const Reprojection reprojection{before, history, now};
  pool.run(static_cast<size_t>(now.height), [&](size_t row, int) {
    for (int x = 0; x < now.width; ++x) {
      const size_t i = now.index(x, static_cast<int>(row));
      moved[i] = reprojection.pixel(i);
    }
  });
  return moved;
}

}  // namespace qray
