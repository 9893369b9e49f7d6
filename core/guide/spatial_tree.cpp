#include "core/guide/spatial_tree.h"

#include <bit>
#include <cmath>

namespace qray {
namespace {

// Spreads 14 bits so that two zeros follow each.
uint64_t spread(uint32_t v) {
  uint64_t x = v;
  x = (x | x << 16) & 0x0000ff0000ff;
  x = (x | x << 8) & 0x00f00f00f00f;
  x = (x | x << 4) & 0x0c30c30c30c3;
  x = (x | x << 2) & 0x249249249249;
  return x;
}

}  // namespace

SpatialTree::SpatialTree(const Bounds3& bounds) {
  const Vec3 d = bounds.hi - bounds.lo;
  const float longest = std::max({d.x, d.y, d.z, 1e-30f});
  // The least power of two whose grid has a cube over the bounds.
  exponent_ = static_cast<int>(std::ceil(std::log2(longest)));
  const auto fits = [&] {
    const float side = std::ldexp(1.0f, exponent_);
    for (int a = 0; a < 3; ++a) {
      origin_[a] = std::floor(bounds.lo[a] / (side / 4)) * (side / 4);
      if (bounds.hi[a] > origin_[a] + side) return false;
    }
    return true;
  };
  while (!fits()) ++exponent_;
  inverse_cell_ = std::ldexp(1.0f, kMaxDepth / 3 - exponent_);
  off_surface_ = 1.5f / inverse_cell_;
  nodes_.emplace_back();
  index_top();
}

uint64_t SpatialTree::code_of(Vec3 p) const {
  constexpr float kLast = (1 << kMaxDepth / 3) - 1;
  const auto cell = [&](int a) {
    return static_cast<uint32_t>(std::clamp((p[a] - origin_[a]) * inverse_cell_, 0.0f, kLast));
  };
  return spread(cell(0)) << 2 | spread(cell(1)) << 1 | spread(cell(2));
}

uint32_t SpatialTree::split(uint32_t leaf) {
  const uint32_t child = static_cast<uint32_t>(nodes_.size());
  const Node parent = nodes_[leaf];
  for (uint64_t half : {0u, 1u}) nodes_.push_back({0, parent.depth + 1, parent.prefix << 1 | half});
  nodes_[leaf].child = child;
  return child;
}

uint32_t SpatialTree::reach(uint64_t halves) {
  uint32_t node = 0;
  for (int bit = std::bit_width(halves) - 2; bit >= 0; --bit) {
    const uint32_t first = nodes_[node].child != 0 ? nodes_[node].child : split(node);
    node = first + static_cast<uint32_t>(halves >> bit & 1);
  }
  return node;
}

Vec3 SpatialTree::extent(uint32_t node) const {
  const int depth = static_cast<int>(nodes_[node].depth);
  const auto side = [&](int axis) { return std::ldexp(1.0f, exponent_ - (depth + 2 - axis) / 3); };
  return {side(0), side(1), side(2)};
}

void SpatialTree::index_top() {
  top_.assign(size_t{1} << kTopDepth, 0);
  for (uint64_t code = 0; code < top_.size(); ++code) {
    uint32_t i = 0;
    for (int bit = kTopDepth - 1; bit >= 0 && nodes_[i].child != 0; --bit)
      i = nodes_[i].child + static_cast<uint32_t>(code >> bit & 1);
    top_[code] = i;
  }
}

}  // namespace qray
