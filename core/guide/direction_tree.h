// Which way, for one state: a quadtree over the unit square, which the concentric map lays over the
// projected hemisphere, so that a tree without data samples by the cosine and
// no cell lies below the horizon. What is learned are integer sums, exactly associative: the same
// bits whatever the threads and the order.
//
// Estimates are shrunk toward the parent cell's (Buehlmann's credibility): of N samples, n of which
// hit the parent, whose area is A, a cell of area a has (S + k w m_parent) / (N a + k w), w = N A /
// n.
//
// Trees are rebuilt between passes; in between add() may be called from any thread, for one tree by
// one at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/byte_io.h"
#include "core/guide/adaptive_params.h"
#include "core/math/wide.h"

namespace qray {

class DirectionTrees {
 public:
  // What a cell was hit by: n samples; S = sum Y/p, p in the square's measure.
  struct Sums {
    int64_t s = 0;
    uint32_t n = 0;
  };
  // A cell of a tree taken out of the store: 0 is the whole square, children are four in a row.
  // Sums are those of the leaves; others are zero.
  struct Cell {
    Sums sums;
    uint32_t child = 0;  // the first of four; 0: a leaf
    uint32_t depth = 0;
    double mean = 1;      // of Y, shrunk
    bool joined = false;  // a leaf that was cut once, and its quarters were alike
  };
  using Cells = std::vector<Cell>;
  // Of a tree that is read or merged: far more than is learned, and what is added to it still fits.
  static constexpr int64_t kMaxSum = int64_t{1} << 60;

  // Density at u, over the unit square.
  float pdf(uint32_t root, Vec2 u) const;
  // Follows the density; `density` is pdf() at the result.
  Vec2 sample(uint32_t root, Vec2 u, float& density) const;
  // The same of several trees, those whose bits are set, with the same bits. The answers of others
  // mean nothing.
  using Roots = std::array<uint32_t, kWidth>;
  void pdf_each(const Roots& roots, const Vec2Lanes& u, uint32_t lanes, FloatLanes& density) const;
  void sample_each(const Roots& roots, const Vec2Lanes& u, uint32_t lanes, Vec2Lanes& at,
                   FloatLanes& density) const;
  // The integral of the squared density over the unit square: 1 where it is uniform, else more.
  double second_moment(uint32_t root) const;
  void add(uint32_t root, Vec2 u, int64_t s);
  void prefetch(uint32_t root) const {
    const char* p = reinterpret_cast<const char*>(&nodes_[root]);
    for (int line = 0; line < 3; ++line) __builtin_prefetch(p + 64 * line);
  }
  float cell_size(uint32_t root, Vec2 u) const;  // the side of the cell that holds u

  // Between passes.
  Cells take(uint32_t root) const;
  uint32_t put(const Cells& cells);                              // a new tree; its root
  uint32_t put_tree(const DirectionTrees& from, uint32_t root);  // as it is
  size_t nodes() const { return nodes_.size(); }
  size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + sums_.capacity() * sizeof(Quad);
  }
  void clear() { nodes_.clear(), sums_.clear(); }
  void shrink() { nodes_.shrink_to_fit(), sums_.shrink_to_fit(); }
  void reserve(size_t nodes) { nodes_.reserve(nodes), sums_.reserve(nodes); }

  // A quadrant's chance within its parent is a whole number of these parts. So none is 0:
  // directions that seemed dark stay possible.
  static constexpr int kChances = 256;

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.nodes_, self.sums_);
  }

  // Of a copy that samples and is added to (guide_share.h): the trees without their sums, which are
  // zero after empty_sums().
  template <class Self, class Archive>
  static void exchange_trees(Self& self, Archive& archive) {
    archive(self.nodes_);
  }
  void empty_sums() { sums_.assign(nodes_.size(), {}); }
  void take_sums(ByteWriter& out);  // what was added since; they are zero again
  // One whose trees are these: what was taken of it.
  struct Added {
    size_t node = 0;
    int quadrant = 0;
    Sums sums;
  };
  // False: it is not of such trees.
  bool read_sums(ByteReader& in, std::vector<Added>& added) const;
  void add_sums(const std::vector<Added>& added);

  // What put() would take.
  static size_t bytes_of(const Cells& cells) {
    return cells.size() / 4 * (sizeof(Node) + sizeof(Quad));
  }

  static Cells one_cell() { return Cells(1); }
  // Fills `mean` of every cell; all 1 without data. take() fills it with the density.
  static void estimate(Cells& cells, float shrinkage);
  // Cuts and joins cells as their shares ask for; the estimates must be filled, and stay so.
  static void adapt(Cells& cells, const DirectionParams& params);
  // Adds a uniform part to the means, `part` of the whole square's over the second moment: so that
  // cells thought dark, which are believed least, do not weigh much when they are drawn.
  static void add_uniform(Cells& cells, float part);
  // Adds to each cell the sums of `other`'s, cut alike first. In either order the result is the
  // same.
  static void add_cells(Cells& cells, const Cells& other);
  static Sums total(const Cells& cells);
  struct Leaf {
    Vec2 corner;  // nearest to (0, 0)
    float size = 0;
    double mean = 0;  // Cell::mean
  };
  static std::vector<Leaf> leaves(const Cells& cells);
  // Sums become numerator / denominator of what they were, rounded toward zero.
  static void scale(Cells& cells, int64_t numerator, int64_t denominator);
  static int64_t scaled(int64_t v, int64_t numerator, int64_t denominator) {
    return v / denominator * numerator + v % denominator * numerator / denominator;
  }

 private:
  // Four quadrants: left before right, then bottom before top.
  struct Node {
    uint8_t p[4];    // chances of the quadrants in kChances, at least 1 each
    uint16_t first;  // node of the first child, counted from the root
    uint8_t inner;   // bit q: quadrant q has a node of its own
    uint8_t joined;  // bit q: Cell::joined
    bool has_child(int q) const { return inner >> q & 1; }
    uint32_t child(int q) const {
      return first + static_cast<uint32_t>(__builtin_popcount(inner & ((1u << q) - 1)));
    }
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.p, self.first, self.inner, self.joined);
    }
  };
  struct WideNodes {
    WideUint p, rest;  // the first four bytes of each node, and the last
    WideUint chance(const WideUint& q) const { return p >> 8 * q & 255; }
    // Of each quadrant q: all bits if it has a node of its own, and that node.
    WideInt has_child(const WideUint& q) const { return (rest >> (16 + q) & 1) != 0; }
    WideUint child(const WideUint& q) const {
      const WideUint before = rest >> 16 & (((WideUint{} + 1) << q) - 1);
      return (rest & 0xffff) + (before & 1) + (before >> 1 & 1) + (before >> 2 & 1);
    }
  };
  WideNodes load(const WideUint& at) const;

  struct Quad {
    int64_t s[4]{};
    uint32_t n[4]{};
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.s, self.n);
    }
  };

  std::vector<Node> nodes_;
  std::vector<Quad> sums_;  // parallel to nodes_
};

}  // namespace qray
