// Where: a power-of-two cube aligned to the world's origin, cut in halves along x, y, z in turn;
// one such tree, or one for each of the six faces a normal can point at. Keys name a cell and a
// tree, whatever the trees look like, so that two tables of one scene are comparable. Not
// synchronised.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/math/ray.h"
#include "core/math/wide.h"

namespace qray {

class SpatialTree {
 public:
  static constexpr int kMaxDepth = 42;  // 2^14 cells a side
  static constexpr int kFaces = 6;      // +x -x +y -y +z -z
  static constexpr uint32_t kNone = ~0u;
  static constexpr size_t kMaxTopBytes = size_t{1} << 20;

  explicit SpatialTree(const Bounds3& bounds, int trees = 1);

  // Which of the six axes the unit normal is nearest to.
  static int face_of(Vec3 n) {
    const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    if (x >= y && x >= z) return n.x < 0;
    if (y >= z) return 2 + (n.y < 0);
    return 4 + (n.z < 0);
  }
  // The same of several, each nearest to +-x, +-y, or else +-z.
  struct WideFace {
    WideInt along_x, along_y, face;
  };
  static WideFace face_of(const WideVec3& n) {
    const Wide x = abs(n.x), y = abs(n.y), z = abs(n.z);
    const WideInt along_x = (x >= y) & (x >= z), along_y = ~along_x & (y >= z);
    const Wide along = along_x ? n.x : along_y ? n.y : n.z;
    const WideInt first = along_x ? WideInt{} : along_y ? WideInt{} + 2 : WideInt{} + 4;
    return {along_x, along_y, first - (along < 0)};
  }
  // The leaf that holds p; points outside count to the nearest cell. Leaves are numbered as they
  // come to be: the first are the trees themselves.
  uint32_t leaf_at(Vec3 p, int tree = 0) const {
    Search search = search_for(p, tree);
    while (go_down(search)) {
    }
    return search.leaf;
  }
  // The same step by step. Each asks memory for what the next one reads, so that searches for
  // several points, which take turns, do not wait for each other's.
  struct Search {
    uint64_t code = 0;
    const uint32_t* link = nullptr;
    int bit = 0;  // of the code, for the next link
    uint32_t leaf = 0;
  };
  Search search_for(Vec3 p, int tree) const { return search_for(code_of(p), tree); }
  // Of several, those whose bits are set.
  using Searches = std::array<Search, kWidth>;
  void search_for(const WideVec3& p, const WideFace& trees, uint32_t lanes,
                  Searches& searches) const;
  bool go_down(Search& search) const {  // false: it is at the leaf
    const uint32_t link = *search.link;
    if (link & kLeaf) {
      search.leaf = link & ~kLeaf;
      return false;
    }
    search.link = &links_[link + static_cast<uint32_t>(search.code >> search.bit-- & 1)];
    __builtin_prefetch(search.link);
    return true;
  }
  // A point of a surface, taken off it along n: where the surface lies in the plane of a cut,
  // rounding would scatter its points over both sides.
  Vec3 beside(Vec3 p, Vec3 n) const { return p + n * off_surface_; }
  float off_surface() const { return off_surface_; }  // metres
  // Whether p lies in the upper half of its leaf, which split() would make a leaf of its own.
  bool in_upper_half(Vec3 p, uint32_t leaf) const {
    return code_of(p) >> (kMaxDepth - 1 - leaves_[leaf].depth) & 1;
  }

  // A leaf becomes its lower half, and the upper is the new leaf that is returned. Call
  // index_top() after a round of cuts.
  uint32_t split(uint32_t leaf);
  // The leaf at the end of a key, cut out where the tree is not as fine yet; kNone where it is
  // finer. The key must be valid.
  uint32_t reach(uint64_t key);
  uint32_t leaf_with(uint64_t key) const;  // the leaf that holds all of the key's; or kNone
  // So that leaf_at() begins deep down; the index takes at most this many bytes.
  void index_top(size_t most_bytes = kMaxTopBytes);
  // Takes what is left of a table's memory beside what is not the tree's.
  void index_within(size_t max_bytes, size_t other_bytes);

  size_t leaves() const { return leaves_.size(); }
  int depth(uint32_t leaf) const { return leaves_[leaf].depth; }
  Vec3 extent(uint32_t leaf) const;  // metres
  // The halves taken, behind a leading 1, then three bits: which tree.
  uint64_t key(uint32_t leaf) const;
  static bool valid_key(uint64_t key, int trees);

  int cube_exponent() const { return exponent_; }  // the cube is 2^exponent metres wide
  Vec3 origin() const { return origin_; }          // metres
  size_t bytes() const {
    return links_.capacity() * 4 + leaves_.capacity() * sizeof(Leaf) + top_.capacity() * 4;
  }

  static constexpr size_t kMaxLeafBytes = 64;  // of bytes(), each; without the index

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.origin_, self.exponent_, self.inverse_cell_, self.off_surface_, self.links_,
            self.leaves_, self.top_depth_, self.top_);
  }
  // Without the index, which who reads it makes anew.
  template <class Self, class Archive>
  static void exchange_cuts(Self& self, Archive& archive) {
    archive(self.origin_, self.exponent_, self.inverse_cell_, self.off_surface_, self.links_,
            self.leaves_);
  }

 private:
  static constexpr uint32_t kLeaf = 1u
                                    << 31;  // of a link: to a leaf, else to the first of two links
  static constexpr int kMaxTopDepth = 15;
  struct Leaf {
    uint64_t prefix = 0;  // the halves taken, the first in the highest bit
    uint32_t link = 0;    // whose it is
    uint8_t depth = 0, tree = 0;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.prefix, self.link, self.depth, self.tree);
    }
  };
  uint64_t code_of(Vec3 p) const;
  Search search_for(uint64_t code, int tree) const {
    const uint32_t* link =
        &top_[static_cast<uint64_t>(tree) << top_depth_ | code >> (kMaxDepth - top_depth_)];
    __builtin_prefetch(link);
    return {code, link, kMaxDepth - 1 - top_depth_, 0};
  }

  Vec3 origin_;  // metres
  int exponent_ = 0;
  float inverse_cell_ = 1;
  float off_surface_ = 0;        // metres
  std::vector<uint32_t> links_;  // the trees' first
  std::vector<Leaf> leaves_;
  int top_depth_ = 0;
  std::vector<uint32_t> top_;  // links at that depth, or of leaves above it, by tree and code
};

}  // namespace qray
