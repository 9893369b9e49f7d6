// Between passes: what DirectionTrees makes of the cells of a tree that was taken out of the store.
#include <algorithm>
#include <cmath>

#include "core/guide/direction_tree.h"

namespace qray {
namespace {

constexpr uint32_t kMinSplitSamples = 32, kMinJoinSamples = 64;
constexpr uint32_t kNew = ~0u;  // a cell that this round made

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
