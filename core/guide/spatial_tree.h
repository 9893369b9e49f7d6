// Where: a power-of-two cube aligned to the world's origin, cut in halves along x, y, z in turn,
// times the six faces a normal can point at. Keys name a cell and a face, whatever the tree looks
// like, so that two tables of one scene are comparable. Not synchronised.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/math/ray.h"

namespace qray {

class SpatialTree {
 public:
  static constexpr int kMaxDepth = 42;  // 2^14 cells a side
  static constexpr int kFaces = 6;      // +x -x +y -y +z -z

  explicit SpatialTree(const Bounds3& bounds);

  // Which of the six axes the unit normal is nearest to.
  static int face_of(Vec3 n) {
    const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    if (x >= y && x >= z) return n.x < 0;
    if (y >= z) return 2 + (n.y < 0);
    return 4 + (n.z < 0);
  }
  // Index of the leaf that holds p; points outside count to the nearest cell.
  uint32_t leaf_at(Vec3 p) const {
    const uint64_t code = code_of(p);
    uint32_t i = top_[code >> (kMaxDepth - kTopDepth)];
    int bit = kMaxDepth - 1 - static_cast<int>(nodes_[i].depth);
    while (nodes_[i].child != 0) i = nodes_[i].child + static_cast<uint32_t>(code >> bit-- & 1);
    return i;
  }
  // The same for a point of a surface, taken off it along n: where the surface lies in the plane of a
  // cut, rounding would scatter its points over both sides.
  uint32_t leaf_at(Vec3 p, Vec3 n) const { return leaf_at(p + n * off_surface_); }
  // A leaf may be cut; call index_top() after a round of cuts.
  struct Node {
    uint32_t child = 0;  // the first of two; 0: a leaf
    uint32_t depth = 0;
    uint64_t prefix = 0;  // the halves taken, the first in the highest bit
  };
  size_t bytes() const { return nodes_.capacity() * sizeof(Node) + top_.capacity() * 4; }
  const std::vector<Node>& nodes() const { return nodes_; }
  uint32_t split(uint32_t leaf);  // the first of its two halves; the second follows it
  // The node at the end of the halves that a key names (without its face), cut out where the tree
  // is not as fine yet; the halves have a leading 1 and at most kMaxDepth bits behind it.
  uint32_t reach(uint64_t halves);
  void index_top();
  Vec3 extent(uint32_t node) const;                // metres
  int cube_exponent() const { return exponent_; }  // the cube is 2^exponent metres wide
  Vec3 origin() const { return origin_; }          // metres

  static uint64_t halves(const Node& node) { return uint64_t{1} << node.depth | node.prefix; }
  static uint64_t key(const Node& node, int face) {
    return halves(node) << 3 | static_cast<uint64_t>(face);
  }

 private:
  static constexpr int kTopDepth = 12;
  uint64_t code_of(Vec3 p) const;

  Vec3 origin_;  // metres
  int exponent_ = 0;
  float inverse_cell_ = 1;
  float off_surface_ = 0;  // metres
  std::vector<Node> nodes_;
  std::vector<uint32_t> top_;  // the deepest node above or at depth kTopDepth, by code
};

}  // namespace qray
