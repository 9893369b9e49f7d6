// The part of a guide that shows what it knows, for views and checks: slower than sampling. Any
// thread, while nothing is learned.
#pragma once

#include <optional>
#include <vector>

#include "core/guide/guide_sampler.h"

namespace qray {

// A part of the directions that a guide tells apart at a point: a standard direction of the thesis,
// or a cell of the unit square that a method lays over its directions.
struct DirectionCell {
  Vec3 wi;  // its middle
  float pdf_w = 0;
  Vec2 corner;     // the cell's nearest to (0, 0)
  float size = 0;  // of the cell's sides; 0: not a cell of a square
};

// What is known of a state, for a person who looks at it.
struct StateSummary {
  float size_m = 0;                // its longest side; 0: has none
  std::optional<uint64_t> visits;  // that its directions were learned from
};

class GuideInspector : public GuideSampler {
 public:
  // By how much the learned density lowers a sample's second moment below that of the density that
  // the method starts from (over the projected hemisphere, the hemisphere or the sphere), if light
  // arrives as the table says. 1 where nothing is known. What guiding gains a whole picture, its
  // costs counted, is another quantity, which the renderer measures to judge its guide.
  virtual float gain(const GuidePoint& point) const = 0;
  // Of a point that is known here.
  virtual std::vector<DirectionCell> directions(const GuidePoint& point) const = 0;
  virtual StateSummary summary(const GuidePoint& point) const = 0;
  // Up to `most` of the states that sampling knows, spread over the table.
  virtual std::vector<GuidePoint> known_points(size_t most) const = 0;
};

// At most `most` of the points, evenly from first to last.
std::vector<GuidePoint> spread_over(std::vector<GuidePoint> points, size_t most);

}  // namespace qray
