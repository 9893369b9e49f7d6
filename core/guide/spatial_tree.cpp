#include "core/guide/spatial_tree.h"

#include <algorithm>
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

SpatialTree::SpatialTree(const Bounds3& bounds, int trees) {
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
  for (int tree = 0; tree < trees; ++tree) {
    links_.push_back(kLeaf | static_cast<uint32_t>(tree));
    leaves_.push_back({0, static_cast<uint32_t>(tree), 0, static_cast<uint8_t>(tree)});
  }
  index_top();
}

uint64_t SpatialTree::code_of(Vec3 p) const {
  constexpr float kLast = (1 << kMaxDepth / 3) - 1;
  const auto cell = [&](int a) {
    return static_cast<uint32_t>(std::clamp((p[a] - origin_[a]) * inverse_cell_, 0.0f, kLast));
  };
  return spread(cell(0)) << 2 | spread(cell(1)) << 1 | spread(cell(2));
}

// As code_of(). A vector of 32 bits holds half of each code.
void SpatialTree::search_for(const WideVec3& p, const WideFace& trees, uint32_t lanes,
                             Searches& searches) const {
  static_assert(kMaxDepth == 42);
  constexpr float kLast = (1 << kMaxDepth / 3) - 1;
  const auto cell = [&](const Wide& at, float origin) {
    const Wide in_cube = (at - origin) * inverse_cell_;
    return (WideUint) __builtin_convertvector(min(max(in_cube, Wide{}), wide(kLast)), WideInt);
  };
  const auto spread_seven = [](WideUint v) {
    v = (v | v << 8) & 0x0000700fu;
    v = (v | v << 4) & 0x000430c3u;
    return (v | v << 2) & 0x00049249u;
  };
  const WideUint x = cell(p.x, origin_.x), y = cell(p.y, origin_.y), z = cell(p.z, origin_.z);
  const auto half = [&](int shift) {
    return spread_seven(x >> shift & 127) << 2 | spread_seven(y >> shift & 127) << 1 |
           spread_seven(z >> shift & 127);
  };
  const WideUint upper = half(7), lower = half(0);
  for_each_lane(lanes, [&](int i) {
    searches[static_cast<size_t>(i)] =
        search_for(uint64_t{upper[i]} << 21 | lower[i], trees.face[i]);
  });
}

uint32_t SpatialTree::split(uint32_t leaf) {
  const uint32_t first = static_cast<uint32_t>(links_.size());
  const uint32_t upper_leaf = static_cast<uint32_t>(leaves_.size());
  Leaf& half = leaves_[leaf];
  links_[half.link] = first;
  links_.push_back(kLeaf | leaf);
  links_.push_back(kLeaf | upper_leaf);
  ++half.depth;
  half.prefix <<= 1;
  half.link = first;
  Leaf upper = half;
  upper.prefix |= 1;
  upper.link = first + 1;
  leaves_.push_back(upper);
  return upper_leaf;
}

uint64_t SpatialTree::key(uint32_t leaf) const {
  const Leaf& l = leaves_[leaf];
  return (uint64_t{1} << l.depth | l.prefix) << 3 | l.tree;
}

bool SpatialTree::valid_key(uint64_t key, int trees) {
  const int depth = std::bit_width(key >> 3) - 1;
  return depth >= 0 && depth <= kMaxDepth && (key & 7) < static_cast<uint64_t>(trees);
}

uint32_t SpatialTree::reach(uint64_t key) {
  uint32_t link = static_cast<uint32_t>(key & 7);
  for (int bit = std::bit_width(key) - 2; bit >= 3; --bit) {
    if (links_[link] & kLeaf) split(links_[link] & ~kLeaf);
    link = links_[link] + static_cast<uint32_t>(key >> bit & 1);
  }
  return links_[link] & kLeaf ? links_[link] & ~kLeaf : kNone;
}

uint32_t SpatialTree::leaf_with(uint64_t key) const {
  uint32_t link = links_[key & 7];
  for (int bit = std::bit_width(key) - 2; bit >= 3 && !(link & kLeaf); --bit)
    link = links_[link + static_cast<uint32_t>(key >> bit & 1)];
  return link & kLeaf ? link & ~kLeaf : kNone;
}

Vec3 SpatialTree::extent(uint32_t leaf) const {
  const int depth = leaves_[leaf].depth;
  const auto side = [&](int axis) { return std::ldexp(1.0f, exponent_ - (depth + 2 - axis) / 3); };
  return {side(0), side(1), side(2)};
}

// As deep as most leaves lie.
void SpatialTree::index_top(size_t most_bytes) {
  std::array<size_t, kMaxDepth + 1> count{};
  size_t trees = 0;
  for (const Leaf& leaf : leaves_) {
    ++count[leaf.depth];
    trees = std::max<size_t>(trees, leaf.tree + size_t{1});
  }
  size_t above = 0;
  for (top_depth_ = 0; top_depth_ < kMaxTopDepth; ++top_depth_) {
    above += count[static_cast<size_t>(top_depth_)];
    if (above * 8 > leaves_.size() * 7 || trees * 8 << top_depth_ > most_bytes) break;
  }
  top_ = std::vector<uint32_t>(trees << top_depth_);
  struct Part {
    uint32_t link;
    int depth;
    size_t begin;  // of top_
  };
  std::vector<Part> open;
  for (uint32_t tree = 0; tree < trees; ++tree)
    open.push_back({links_[tree], 0, size_t{tree} << top_depth_});
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    const size_t size = size_t{1} << (top_depth_ - part.depth);
    if (part.link & kLeaf || size == 1) {
      std::fill_n(top_.begin() + static_cast<std::ptrdiff_t>(part.begin), size, part.link);
    } else {
      open.push_back({links_[part.link], part.depth + 1, part.begin});
      open.push_back({links_[part.link + 1], part.depth + 1, part.begin + size / 2});
    }
  }
}

void SpatialTree::index_within(size_t max_bytes, size_t other_bytes) {
  index_top(0);
  const size_t taken = other_bytes + bytes();
  if (taken < max_bytes) index_top(max_bytes - taken);
}

}  // namespace qray
