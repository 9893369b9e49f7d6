#include "core/guide/direction_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/check.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr float kChance = 1.0f / DirectionTrees::kChances;
constexpr uint32_t kMinSplitSamples = 32, kMinJoinSamples = 64;
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

// A leaf becomes four, which share its sums.
void cut_in_four(DirectionTrees::Cells& cells, uint32_t i) {
  DirectionTrees::Cell child;
  child.depth = cells[i].depth + 1;
  child.mean = cells[i].mean;
  cells[i].child = static_cast<uint32_t>(cells.size());
  for (int q = 0; q < 4; ++q) {
    child.sums = quarter(cells[i].sums, q == 0);
    cells.push_back(child);
  }
  cells[i].sums = {};
  cells[i].joined = false;
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

// What arrives in the cell, by its estimate.
double flux(const DirectionTrees::Cell& cell) {
  return std::ldexp(cell.mean, -2 * static_cast<int>(cell.depth));
}

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
  const float a = std::copysign(select(ax >= ay, far, near), d.x);
  const float b = std::copysign(select(ax >= ay, near, far), d.y);
  return {std::clamp(0.5f * (a + 1), 0.0f, kOneMinusEpsilon),
          std::clamp(0.5f * (b + 1), 0.0f, kOneMinusEpsilon)};
}

namespace {
// 2^32 / n.
constexpr auto kInverses = [] {
  std::array<uint64_t, DirectionTrees::kChances + 1> all{};
  for (uint64_t n = 1; n < all.size(); ++n) all[n] = (uint64_t{1} << 32) / n;
  return all;
}();

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
    if (!node.has_child(q)) return density;
    i = node.child(q);
  }
}

// In whole numbers, and without branches but the last: nothing could predict the choices.
Vec2 DirectionTrees::sample(uint32_t root, Vec2 u, float& density) const {
  static_assert(kChances == 256);
  const Node* nodes = &nodes_[root];
  uint64_t ux = static_cast<uint64_t>(u.x * 0x1p32f), uy = static_cast<uint64_t>(u.y * 0x1p32f);
  uint32_t x = 0, y = 0;  // of the cell
  float parts = 1;
  int depth = 0;
  for (uint32_t i = 0;;) {
    const Node& node = nodes[i];
    const uint32_t p = std::bit_cast<uint32_t>(node.p), bottom = (p & 255) + (p >> 8 & 255);
    const uint32_t top = uy >= uint64_t{bottom} << 24;
    const uint32_t row = bottom + top * (kChances - 2 * bottom);
    uy -= uint64_t{top * bottom} << 24;
    uy = uy * kInverses[row] >> 24;
    ux = ux * row >> 8;
    const uint32_t left = p >> 16 * top & 255, right = ux >= uint64_t{left} << 24;
    const uint32_t q = 2 * top + right, cell = p >> 8 * q & 255;
    ux -= uint64_t{right * left} << 24;
    ux = ux * kInverses[cell] >> 24;
    x = 2 * x + right;
    y = 2 * y + top;
    ++depth;
    parts *= static_cast<float>(cell) * (4.0f / kChances);
    if (!node.has_child(static_cast<int>(q))) break;
    i = node.child(static_cast<int>(q));
  }
  density = parts;
  // The first 24 bits of cell and rest: exact, so that no rounding leaves the cell.
  const auto place = [depth](uint32_t cell, uint64_t rest) {
    return static_cast<float>((uint64_t{cell} << 32 | rest) >> (8 + depth)) * 0x1p-24f;
  };
  return {place(x, ux), place(y, uy)};
}

void DirectionTrees::add(uint32_t root, Vec2 u, int64_t s) {
  Descent descent(u);
  for (uint32_t i = 0;;) {
    const int q = descent.next();
    const Node& node = nodes_[root + i];
    if (!node.has_child(q)) {
      sums_[root + i].s[q] += s;
      ++sums_[root + i].n[q];
      return;
    }
    i = node.child(q);
  }
}

float DirectionTrees::cell_size(uint32_t root, Vec2 u) const {
  Descent descent(u);
  float size = 1;
  for (uint32_t i = 0;;) {
    size *= 0.5f;
    const Node& node = nodes_[root + i];
    const int q = descent.next();
    if (!node.has_child(q)) return size;
    i = node.child(q);
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
      if (node.has_child(q)) {
        open.emplace_back(root + node.child(q), part);
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
      c.sums = {sums_[i].s[q], sums_[i].n[q]};
      c.joined = node.joined >> q & 1;
      cells.push_back(c);
      if (node.has_child(q))
        open.push_back({child + static_cast<uint32_t>(q), root + node.child(q)});
    }
  }
  return cells;
}

std::vector<DirectionTrees::Leaf> DirectionTrees::leaves(const Cells& cells) {
  std::vector<Leaf> leaves;
  std::vector<std::pair<uint32_t, Vec2>> open{{0, {0, 0}}};  // cell, its corner
  while (!open.empty()) {
    const auto [i, corner] = open.back();
    open.pop_back();
    const Cell& cell = cells[i];
    const float size = std::ldexp(1.0f, -static_cast<int>(cell.depth));
    if (cell.child == 0) {
      leaves.push_back({corner, size, cell.mean});
      continue;
    }
    for (uint32_t q = 0; q < 4; ++q)
      open.push_back({cell.child + q, corner + Vec2{static_cast<float>(q & 1) * size / 2,
                                                    static_cast<float>(q >> 1) * size / 2}});
  }
  return leaves;
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
    node.first = static_cast<uint16_t>(open.size());
    int largest = 0, rest = kChances;
    for (int q = 0; q < 4; ++q) {
      const double share = sum > 0 ? four[q].mean / sum : 0.25;
      const int chance =
          std::clamp(static_cast<int>(std::lround(share * kChances)), 1, kChances - 3);
      node.p[q] = static_cast<uint8_t>(chance);
      rest -= chance;
      if (four[q].mean > four[largest].mean) largest = q;
      if (four[q].joined) node.joined |= static_cast<uint8_t>(1 << q);
      quad.s[q] = four[q].sums.s;
      quad.n[q] = four[q].sums.n;
      if (four[q].child != 0) {
        node.inner |= static_cast<uint8_t>(1 << q);
        open.push_back(cells[open[k]].child + static_cast<uint32_t>(q));
      }
    }
    node.p[largest] = static_cast<uint8_t>(node.p[largest] + rest);
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

void DirectionTrees::add_cells(Cells& cells, const Cells& other) {
  struct Pair {
    uint32_t to;
    Cell from;
  };
  std::vector<Pair> open{{0, other[0]}};
  while (!open.empty()) {
    const Pair pair = open.back();
    open.pop_back();
    const Cell& from = pair.from;
    if (from.child != 0 && cells[pair.to].child == 0) cut_in_four(cells, pair.to);
    if (cells[pair.to].child == 0) {
      cells[pair.to].sums += from.sums;
      cells[pair.to].joined &= from.joined;
      continue;
    }
    for (uint32_t q = 0; q < 4; ++q) {
      Cell part;
      if (from.child != 0) {
        part = other[from.child + q];
      } else {
        part.sums = quarter(from.sums, q == 0);
      }
      open.push_back({cells[pair.to].child + q, part});
    }
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

void DirectionTrees::add_uniform(Cells& cells, float part) {
  double mean = 0, square = 0;  // over the square
  for (const Cell& c : cells) {
    if (c.child != 0) continue;
    mean += flux(c);
    square += flux(c) * c.mean;
  }
  if (!(square > 0)) return;
  const double uniform = static_cast<double>(part) * mean * mean * mean / square;
  for (Cell& c : cells) c.mean += uniform;
}

namespace {
// How much of the second moment the cut of a cell into four leaves saves, beyond what noise would
// make of equal ones; much, while that is not known.
double gain_of_cut(const DirectionTrees::Cells& cells, const std::vector<DirectionTrees::Sums>& all,
                   uint32_t cell, double share) {
  const DirectionTrees::Cell* four = &cells[cells[cell].child];
  const double n = all[cell].n;
  if (n < kMinJoinSamples) return 1;
  double sum = 0, squares = 0;
  for (int q = 0; q < 4; ++q) {
    if (four[q].child != 0) return 1;
    sum += four[q].mean;
    squares += four[q].mean * four[q].mean;
  }
  return sum > 0 ? share * (4 * squares / (sum * sum) - 1 - 3 / n) : 0;
}
}  // namespace

void DirectionTrees::adapt(Cells& cells, const DirectionParams& params) {
  const std::vector<Sums> all = totals(cells);
  double sum = 0;  // what arrives in all
  for (const Cell& c : cells)
    if (c.child == 0) sum += flux(c);
  Cells out(1);
  out[0] = cells[0];
  std::vector<uint32_t> from{0};  // the old cell of each new one
  for (size_t i = 0; i < out.size(); ++i) {
    const uint32_t old = from[i];
    if (old == kNew) continue;
    const double share = sum > 0 ? flux(cells[old]) / sum : 0;
    const bool was_cut = cells[old].child != 0;
    const bool root = i == 0;
    const bool alike =
        was_cut && !root && gain_of_cut(cells, all, old, share) < params.min_split_gain;
    if (was_cut && (root || (share >= params.split_share / 4 && !alike))) {
      out[i].child = static_cast<uint32_t>(out.size());
      for (uint32_t q = 0; q < 4; ++q) {
        out.push_back(cells[cells[old].child + q]);
        from.push_back(cells[old].child + q);
      }
    } else if (was_cut) {
      out[i].child = 0;
      out[i].sums = all[old];
      out[i].joined = alike;
    } else if (root || (!cells[old].joined && share > params.split_share &&
                        cells[old].sums.n >= kMinSplitSamples &&
                        static_cast<int>(cells[old].depth) < params.max_depth)) {
      cut_in_four(out, static_cast<uint32_t>(i));
      from.resize(out.size(), kNew);
    }
  }
  cells = std::move(out);
}

}  // namespace qray
