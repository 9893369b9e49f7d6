#include "core/guide/direction_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kChance = 1.0f / DirectionTrees::kChances;
constexpr size_t kMaxNodes = 0xffff;  // of one tree: Node::first has 16 bits

// 2^32 / n.
constexpr auto kInverses = [] {
  std::array<uint64_t, DirectionTrees::kChances + 1> all{};
  for (uint64_t n = 1; n < all.size(); ++n) all[n] = (uint64_t{1} << 32) / n;
  return all;
}();

// a b / 2^bits.
WideUint multiplied(const WideUint& a, const WideUint& b, int bits) {
  WideUint product;
  for (int i = 0; i < kWidth; ++i)
    product[i] = static_cast<uint32_t>(uint64_t{a[i]} * b[i] >> bits);
  return product;
}

// a * kInverses[n] / 2^24.
WideUint over(const WideUint& a, const WideUint& n) {
  WideUint inverse;
  for (int i = 0; i < kWidth; ++i) inverse[i] = static_cast<uint32_t>(kInverses[n[i]]);
  return n == 1 ? a << 8 : multiplied(a, inverse, 24);
}

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

DirectionTrees::WideNodes DirectionTrees::load(const WideUint& at) const {
  static_assert(sizeof(Node) == 8 && std::endian::native == std::endian::little);
  alignas(WideUint) uint32_t first[kWidth], last[kWidth];
  for (int i = 0; i < kWidth; ++i) {
    const uint64_t node = std::bit_cast<uint64_t>(nodes_[at[i]]);
    first[i] = static_cast<uint32_t>(node);
    last[i] = static_cast<uint32_t>(node >> 32);
  }
  WideNodes nodes;
  std::memcpy(&nodes.p, first, sizeof first);
  std::memcpy(&nodes.rest, last, sizeof last);
  return nodes;
}

void DirectionTrees::pdf_each(const Roots& roots, const Vec2Lanes& u, uint32_t lanes,
                              FloatLanes& density) const {
  WideInt open = mask_of(lanes);
  WideUint root;
  std::memcpy(&root, &roots, sizeof root);
  root &= (WideUint)open;
  WideUint x = (WideUint) __builtin_convertvector(u.x.wide() * 0x1p24f, WideInt) << 8;
  WideUint y = (WideUint) __builtin_convertvector(u.y.wide() * 0x1p24f, WideInt) << 8;
  Wide parts = wide(1);
  for (WideUint at = root; lanes_of(open);) {
    const WideNodes nodes = load(at);
    const WideUint q = y >> 31 << 1 | x >> 31;
    const Wide part = 4 * kChance * __builtin_convertvector((WideInt)nodes.chance(q), Wide);
    parts = open ? parts * part : parts;
    open &= nodes.has_child(q);
    at = open ? root + nodes.child(q) : at;
    x <<= 1;
    y <<= 1;
  }
  density = parts;
}

// sample(), step by step.
void DirectionTrees::sample_each(const Roots& roots, const Vec2Lanes& u, uint32_t lanes,
                                 Vec2Lanes& at, FloatLanes& density) const {
  const auto start = [](const FloatLanes& v) {
    return (WideUint) __builtin_convertvector(v.wide() * 0x1p24f, WideInt) << 8;
  };
  WideInt open = mask_of(lanes);
  WideUint root;
  std::memcpy(&root, &roots, sizeof root);
  root &= (WideUint)open;
  WideUint ux = start(u.x), uy = start(u.y), x{}, y{}, depth{};
  Wide parts = wide(1);
  for (WideUint node = root; lanes_of(open);) {
    const WideNodes nodes = load(node);
    const WideUint p = nodes.p, bottom = (p & 255) + (p >> 8 & 255);
    const WideInt top = uy >= bottom << 24;
    const WideUint row = top ? kChances - bottom : bottom;
    const WideUint in_row = uy - (top ? bottom << 24 : WideUint{});
    const WideUint across = multiplied(ux, row, 8);
    const WideUint left = top ? p >> 16 & 255 : p & 255;
    const WideInt right = across >= left << 24;
    const WideUint in_cell = across - (right ? left << 24 : WideUint{});
    const WideUint q = ((WideUint)top & 2) | ((WideUint)right & 1), cell = nodes.chance(q);
    uy = open ? over(in_row, row) : uy;
    ux = open ? over(in_cell, cell) : ux;
    x = open ? 2 * x + (q & 1) : x;
    y = open ? 2 * y + (q >> 1) : y;
    depth -= (WideUint)open;
    const Wide part = __builtin_convertvector((WideInt)cell, Wide) * (4.0f / kChances);
    parts = open ? parts * part : parts;
    open &= nodes.has_child(q);
    node = open ? root + nodes.child(q) : node;
  }
  density = parts;
  // The first 24 bits of cell and rest: as sample() has them.
  const auto place = [&](const WideUint& of, const WideUint& rest) {
    const WideUint bits = of << (24 - depth) | rest >> (8 + depth);
    return __builtin_convertvector((WideInt)bits, Wide) * 0x1p-24f;
  };
  at.x = place(x, ux);
  at.y = place(y, uy);
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

uint32_t DirectionTrees::put_tree(const DirectionTrees& from, uint32_t root) {
  const uint32_t put = static_cast<uint32_t>(nodes_.size());
  uint32_t nodes = 1;  // level by level, as put() lays them out
  for (uint32_t i = 0; i < nodes; ++i)
    nodes += static_cast<uint32_t>(__builtin_popcount(from.nodes_[root + i].inner));
  nodes_.insert(nodes_.end(), from.nodes_.begin() + root, from.nodes_.begin() + root + nodes);
  sums_.insert(sums_.end(), from.sums_.begin() + root, from.sums_.begin() + root + nodes);
  return put;
}

}  // namespace qray
