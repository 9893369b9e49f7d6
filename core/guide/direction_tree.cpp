#include "core/guide/direction_tree.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kChance = 0x1p-16f;
constexpr uint32_t kMinSplitSamples = 32;
constexpr uint32_t kNew = ~0u;        // a cell that this round made
constexpr size_t kMaxNodes = 0xffff;  // of one tree: Node::first has 16 bits

// Parts of sums for four new cells: equal, the rest to the first, so that no bit is lost.
DirectionTrees::Sums quarter(const DirectionTrees::Sums& sums, bool first) {
  const auto part = [first](auto v) {
    return static_cast<decltype(v)>(v / 4 + (first ? v % 4 : 0));
  };
  return {part(sums.s), part(sums.n)};
}

DirectionTrees::Sums& operator+=(DirectionTrees::Sums& a, const DirectionTrees::Sums& b) {
  a.s += b.s;
  a.n += b.n;
  return a;
}

// Sums of each cell with all that is below it.
std::vector<DirectionTrees::Sums> totals(const DirectionTrees::Cells& cells) {
  std::vector<DirectionTrees::Sums> all(cells.size());
  for (size_t i = cells.size(); i-- > 0;) {  // children stand behind their parents
    all[i] += cells[i].sums;
    for (uint32_t q = 0; cells[i].child != 0 && q < 4; ++q) all[i] += all[cells[i].child + q];
  }
  return all;
}

double to_double(int64_t v) { return static_cast<double>(v); }

}  // namespace

Vec2 disk_to_square(Vec2 d) {
  const float ax = std::abs(d.x), ay = std::abs(d.y);
  const float hi = std::max(ax, ay), lo = std::min(ax, ay);
  if (hi == 0) return {0.5f, 0.5f};
  const float r = std::sqrt(ax * ax + ay * ay), t = lo / hi, t2 = t * t;
  // 4/pi atan(t) on [0, 1] (Abramowitz and Stegun 4.4.49, shortened).
  const float angle =
      t * (1.2732104f + t2 * (-0.42350938f +
                              t2 * (0.24642503f +
                                    t2 * (-0.14824690f + t2 * (0.06704038f + t2 * -0.01492391f)))));
  const float far = r, near = angle * r;
  const float a = std::copysign(ax >= ay ? far : near, d.x);
  const float b = std::copysign(ax >= ay ? near : far, d.y);
  return {std::clamp(0.5f * (a + 1), 0.0f, kOneMinusEpsilon),
          std::clamp(0.5f * (b + 1), 0.0f, kOneMinusEpsilon)};
}

DirectionTrees::Quad::Quad(const Quad& o) {
  for (int q = 0; q < 4; ++q) {
    s[q] = o.s[q].load(std::memory_order_relaxed);
    n[q] = o.n[q].load(std::memory_order_relaxed);
  }
}

namespace {
// Walks down to the cell that holds u.
class Descent {
 public:
  explicit Descent(Vec2 u)
      : x_(static_cast<uint32_t>(u.x * 0x1p24f)), y_(static_cast<uint32_t>(u.y * 0x1p24f)) {}
  int next() {
    --bit_;
    return static_cast<int>((y_ >> bit_ & 1) << 1 | (x_ >> bit_ & 1));
  }

 private:
  uint32_t x_, y_;
  int bit_ = 24;
};
}  // namespace

float DirectionTrees::pdf(uint32_t root, Vec2 u) const {
  const Node* nodes = &nodes_[root];
  Descent descent(u);
  float density = 1;
  for (uint32_t i = 0;;) {
    const Node& node = nodes[i];
    const int q = descent.next();
    density *= 4 * kChance * static_cast<float>(node.p[q]);
    i = node.child[q];
    if (i == 0) return density;
  }
}

// The compiler makes no branches of the choices, which nothing could predict.
Vec2 DirectionTrees::sample(uint32_t root, Vec2 u, float& density) const {
  const Node* nodes = &nodes_[root];
  float x = 0, y = 0, size = 1;
  density = 1;
  for (uint32_t i = 0;;) {
    const Node& node = nodes[i];
    const float p0 = node.p[0], p1 = node.p[1], p2 = node.p[2], p3 = node.p[3];
    const float bottom = p0 + p1, above = u.y * 0x1p16f - bottom;
    const bool top = above >= 0;
    const float row = top ? p2 + p3 : bottom, left = top ? p2 : p0;
    const float beyond = u.x * row - left;
    const bool right = beyond >= 0;
    const float cell = right ? row - left : left;
    u.y = std::min((top ? above : above + bottom) / row, kOneMinusEpsilon);
    u.x = std::min((right ? beyond : beyond + left) / cell, kOneMinusEpsilon);
    size *= 0.5f;
    x += right ? size : 0;
    y += top ? size : 0;
    density *= 4 * kChance * cell;
    i = node.child[2 * top + right];
    if (i == 0) return {x + u.x * size, y + u.y * size};
  }
}

void DirectionTrees::add(uint32_t root, Vec2 u, int64_t s) {
  Descent descent(u);
  for (uint32_t i = 0;;) {
    const int q = descent.next();
    const uint32_t child = nodes_[root + i].child[q];
    if (child == 0) {
      sums_[root + i].s[q].fetch_add(s, std::memory_order_relaxed);
      sums_[root + i].n[q].fetch_add(1, std::memory_order_relaxed);
      return;
    }
    i = child;
  }
}

float DirectionTrees::cell_size(uint32_t root, Vec2 u) const {
  Descent descent(u);
  float size = 1;
  for (uint32_t i = 0;;) {
    size *= 0.5f;
    i = nodes_[root + i].child[descent.next()];
    if (i == 0) return size;
  }
}

double DirectionTrees::second_moment(uint32_t root) const {
  double sum = 0;
  std::vector<std::pair<uint32_t, double>> open{{root, 1.0}};  // a node, its density^2 x area
  while (!open.empty()) {
    const auto [i, moment] = open.back();
    open.pop_back();
    const Node& node = nodes_[i];
    for (int q = 0; q < 4; ++q) {
      const double chance = static_cast<double>(kChance * static_cast<float>(node.p[q]));
      const double part = moment * 4 * chance * chance;
      if (node.child[q] != 0) {
        open.emplace_back(root + node.child[q], part);
      } else {
        sum += part;
      }
    }
  }
  return sum;
}

DirectionTrees::Cells DirectionTrees::take(uint32_t root) const {
  Cells cells(1);
  std::vector<std::pair<uint32_t, uint32_t>> open{{0, root}};  // cell, its node
  for (size_t k = 0; k < open.size(); ++k) {
    const auto [cell, i] = open[k];
    const Node& node = nodes_[i];
    const uint32_t child = static_cast<uint32_t>(cells.size());
    cells[cell].child = child;
    for (int q = 0; q < 4; ++q) {
      Cell c;
      c.depth = cells[cell].depth + 1;
      c.mean = cells[cell].mean * 4 * static_cast<double>(kChance * static_cast<float>(node.p[q]));
      c.sums = {sums_[i].s[q].load(std::memory_order_relaxed),
                sums_[i].n[q].load(std::memory_order_relaxed)};
      cells.push_back(c);
      if (node.child[q] != 0)
        open.push_back({child + static_cast<uint32_t>(q), root + node.child[q]});
    }
  }
  return cells;
}

uint32_t DirectionTrees::put(const Cells& cells) {
  const uint32_t root = static_cast<uint32_t>(nodes_.size());
  QRAY_CHECK(cells[0].child != 0 && cells.size() / 4 <= kMaxNodes);
  std::vector<uint32_t> open{0};  // cells, in the order of their nodes
  for (size_t k = 0; k < open.size(); ++k) {
    const Cell* four = &cells[cells[open[k]].child];
    Node node{};
    Quad quad;
    double sum = 0;
    for (int q = 0; q < 4; ++q) sum += four[q].mean;
    int largest = 0, rest = 1 << 16;
    for (int q = 0; q < 4; ++q) {
      const double share = sum > 0 ? four[q].mean / sum : 0.25;
      const int chance = std::clamp(static_cast<int>(std::lround(share * 0x1p16)), 1, 0xfffd);
      node.p[q] = static_cast<uint16_t>(chance);
      rest -= chance;
      if (four[q].mean > four[largest].mean) largest = q;
      quad.s[q] = four[q].sums.s;
      quad.n[q] = four[q].sums.n;
      if (four[q].child != 0) {
        node.child[q] = static_cast<uint16_t>(open.size());
        open.push_back(cells[open[k]].child + static_cast<uint32_t>(q));
      }
    }
    node.p[largest] = static_cast<uint16_t>(node.p[largest] + rest);
    nodes_.push_back(node);
    sums_.push_back(quad);
  }
  return root;
}

void DirectionTrees::scale(Cells& cells, int64_t numerator, int64_t denominator) {
  for (Cell& c : cells) {
    c.sums.s = scaled(c.sums.s, numerator, denominator);
    c.sums.n = static_cast<uint32_t>(scaled(c.sums.n, numerator, denominator));
  }
}

DirectionTrees::Sums DirectionTrees::total(const Cells& cells) { return totals(cells)[0]; }

void DirectionTrees::estimate(Cells& cells, float shrinkage) {
  const std::vector<Sums> all = totals(cells);
  const double n = all[0].n;
  cells[0].mean = n > 0 && all[0].s > 0 ? to_double(all[0].s) / n : 1;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].child == 0) continue;
    const double area = std::ldexp(n, -2 * static_cast<int>(cells[i].depth));  // x samples
    const double prior = static_cast<double>(shrinkage) * (all[i].n > 0 ? area / all[i].n : 1);
    for (uint32_t c = cells[i].child; c < cells[i].child + 4; ++c) {
      const double weight = area / 4 + prior;
      cells[c].mean =
          weight > 0 ? (to_double(all[c].s) + prior * cells[i].mean) / weight : cells[i].mean;
    }
  }
}

void DirectionTrees::adapt(Cells& cells, const DirectionParams& params) {
  const std::vector<Sums> all = totals(cells);
  // What arrives in all, by the leaves' estimates.
  const auto flux = [&cells](size_t i) {
    return std::ldexp(cells[i].mean, -2 * static_cast<int>(cells[i].depth));
  };
  double sum = 0;
  for (size_t i = 0; i < cells.size(); ++i)
    if (cells[i].child == 0) sum += flux(i);
  Cells out(1);
  out[0] = cells[0];
  std::vector<uint32_t> from{0};  // the old cell of each new one
  for (size_t i = 0; i < out.size(); ++i) {
    const uint32_t old = from[i];
    if (old == kNew) continue;
    const double share = sum > 0 ? flux(old) / sum : 0;
    const bool was_cut = cells[old].child != 0;
    const bool root = i == 0;
    if (was_cut && (root || share >= params.split_share / 4)) {
      out[i].child = static_cast<uint32_t>(out.size());
      for (uint32_t q = 0; q < 4; ++q) {
        out.push_back(cells[cells[old].child + q]);
        from.push_back(cells[old].child + q);
      }
    } else if (was_cut) {
      out[i].child = 0;
      out[i].sums = all[old];
    } else if (root || (share > params.split_share && cells[old].sums.n >= kMinSplitSamples &&
                        static_cast<int>(cells[old].depth) < params.max_depth)) {
      Cell child;
      child.depth = out[i].depth + 1;
      child.mean = out[i].mean;
      out[i].child = static_cast<uint32_t>(out.size());
      for (uint32_t q = 0; q < 4; ++q) {
        child.sums = quarter(cells[old].sums, q == 0);
        out.push_back(child);
        from.push_back(kNew);
      }
      out[i].sums = {};
    }
  }
  cells = std::move(out);
}

}  // namespace qray
