#include "core/guide/guide_inspector.h"

#include <algorithm>

namespace qray {

std::vector<GuidePoint> spread_over(std::vector<GuidePoint> points, size_t most) {
  const size_t known = points.size(), count = std::min(known, most);
  for (size_t i = 0; i < count; ++i) points[i] = points[i * known / count];
  points.resize(count);
  return points;
}

}  // namespace qray
