#include "core/render/light_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/math/hash.h"

namespace qray {
namespace {

// Cosines are off by this much at most; what is closer to the edge of a bound is within it.
constexpr float kSlack = 1e-3f;
constexpr float kTiny = 1e-30f;

inline Wide load(const std::array<float, kWidth>& from) {
  Wide v;
  std::memcpy(&v, from.data(), sizeof v);
  return v;
}
inline float sum_of(const std::array<float, kWidth>& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace

bool differ(std::span<const LightBounds> lights, float apart) {
  Bounds3 box;
  for (const LightBounds& light : lights) {
    box.add(light.box.lo);
    box.add(light.box.hi);
    if (light.cos_spread < 1 || light.two_sided != lights[0].two_sided ||
        light.cos_emission != lights[0].cos_emission ||
        !(dot(light.axis, lights[0].axis) > 1 - kSlack))
      return true;
  }
  return length(box.extent()) > apart;
}

// About the light that each child sends to the point: intensity times cosines over squared
// distance, each the most that any place in its sphere and any direction in its cone allows. In the
// sphere, distance is its radius: never less than where most of its lights are. Sines and cosines
// are kept times the distance, and their products times its square, so that no root waits for
// another and there is one division.
inline LightTree::Weights LightTree::weigh(const Node& node, const LightReceiver& at) {
  const Wide zero{};
  const Wide x = at.p.x - load(node.x), y = at.p.y - load(node.y), z = at.p.z - load(node.z);
  const Wide d2 = max(x * x + y * y + z * z, wide(kTiny)), over_d2 = 1 / d2;
  const Wide slack = d2 * kSlack;
  const Wide radius = load(node.radius), radius2 = radius * radius;
  const Wide sphere = sqrt(max(d2 - radius2, zero));  // d times the cosine at the sphere's edge

  // The least angle between where the light goes and the cone.
  const Wide plain = x * load(node.axis_x) + y * load(node.axis_y) + z * load(node.axis_z);
  const Wide axis = load(node.two_sided) > 0 ? max(plain, -plain) : plain;
  const Wide off_axis = sqrt(max(d2 - axis * axis, zero));
  const Wide cos_spread = load(node.cos_spread), sin_spread = load(node.sin_spread);
  const Wide past = axis * cos_spread + off_axis * sin_spread;
  const Wide off_past = off_axis * cos_spread - axis * sin_spread;
  const WideInt within = d2 <= radius2;
  const WideInt in_cone = axis * max(axis, -axis) >= d2 * cos_spread * max(cos_spread, -cos_spread);
  const Wide leaving =
      (within | in_cone | (past >= sphere)) != 0 ? d2 : past * sphere + off_past * radius;
  const Wide sent = leaving > load(node.cos_emission) * d2 ? max(leaving, slack) : zero;

  // The least angle between where it comes from and the normal.
  const Wide normal = x * -at.n.x + y * -at.n.y + z * -at.n.z;
  const Wide off_normal = sqrt(max(d2 - normal * normal, zero));
  const Wide arriving =
      (within | (normal >= sphere)) != 0 ? d2 : normal * sphere + off_normal * radius;
  Wide received = arriving > -slack ? max(arriving, slack) : zero;
  if (at.n.x == 0 && at.n.y == 0 && at.n.z == 0) received = d2;

  const Wide weight = load(node.intensity) * (sent * over_d2) * (received * over_d2) *
                      min(over_d2, load(node.over_radius2));
  Weights w;
  std::memcpy(w.of.data(), &weight, sizeof weight);
  w.sum = sum_of(w.of);
  return w;
}

inline void LightTree::scale(Weights& w, const float* factors) {
  Wide scales;
  std::memcpy(&scales, factors, sizeof scales);
  const Wide scaled = load(w.of) * scales;
  std::memcpy(w.of.data(), &scaled, sizeof scaled);
  w.sum = sum_of(w.of);
}

// The lane in which `u` of the sum lies, and how far in it. Without branches on which it is, since
// nobody can tell that before. Sums are taken in pairs, so that few wait for others; a lane that
// weighs nothing adds nothing to any.
inline LightTree::LaneAt LightTree::lane_at(const Weights& w, double u) {
  const double target = u * double{w.sum};
  std::array<double, kLanes> of;
  for (size_t i = 0; i < kLanes; ++i) of[i] = double{w.of[i]};
  const double of01 = of[0] + of[1], of45 = of[4] + of[5], of67 = of[6] + of[7];
  const double of0123 = of01 + (of[2] + of[3]), of012345 = of0123 + of45;
  const std::array<double, kLanes + 1> below{0,
                                             of[0],
                                             of01,
                                             of01 + of[2],
                                             of0123,
                                             of0123 + of[4],
                                             of012345,
                                             of012345 + of[6],
                                             of012345 + of67};
  size_t lane = 0;
  for (size_t i = 1; i <= kLanes; ++i) lane += below[i] <= target ? 1 : 0;
  if (lane == kLanes)  // by rounding: the last that weighs something
    while (!(w.of[--lane] > 0)) {
    }
  return {lane, std::clamp((target - below[lane]) / double{w.of[lane]}, 0.0, 1.0)};
}

inline bool LightTree::go_down(Search& search) const {
  const Node& node = nodes_[search.node];
  Weights w = weigh(node, search.at);
  const uint32_t cluster = search.factors ? first_cluster(search.node) : kNoGroup;
  Lanes plain;
  if (cluster != kNoGroup) {
    plain = w.of;
    scale(w, search.factors + cluster);
  }
  if (!(w.sum > 0) || !std::isfinite(w.sum)) {
    search.pick = {};
    return false;
  }
  const LaneAt at_lane = lane_at(w, search.u);
  const size_t lane = at_lane.lane;
  search.u = at_lane.u;
  search.pick.probability *= w.of[lane] / w.sum;
  if (cluster != kNoGroup)
    search.passed[search.passed_count++] = {cluster + static_cast<uint32_t>(lane),
                                            search.pick.probability / plain[lane]};
  search.node = node.child[lane];
  if (search.node & kLight) {
    search.pick.light = search.node & ~kLight;
    return false;
  }
  const auto* next = reinterpret_cast<const std::byte*>(&nodes_[search.node]);
  for (size_t line = 0; line < sizeof(Node); line += 64) __builtin_prefetch(next + line);
  return true;
}

void LightTree::run(std::span<Search> searches, uint32_t lanes) const {
  while (lanes)
    for_each_lane(lanes, [&](int lane) {
      if (!go_down(searches[static_cast<size_t>(lane)])) lanes &= ~(1u << lane);
    });
}

float LightTree::probability(const LightReceiver& at, uint32_t light, const float* factors) const {
  float probability = 1;
  for (uint32_t slot = slot_of_light_[light];; slot = nodes_[slot / kLanes].parent) {
    const uint32_t node = slot / kLanes, cluster = factors ? first_cluster(node) : kNoGroup;
    Weights w = weigh(nodes_[node], at);
    if (cluster != kNoGroup) scale(w, factors + cluster);
    if (!(w.sum > 0) || !std::isfinite(w.sum)) return 0;
    probability *= w.of[slot % kLanes] / w.sum;
    if (slot < kLanes) return probability;
  }
}

std::vector<uint32_t> LightTree::clusters() const {
  std::vector<uint32_t> groups{kLanes};
  for (const uint32_t child : nodes_[0].child)
    if (child != kNoChild && !(child & kLight)) groups.push_back(kLanes);
  return groups;
}

uint64_t LightTree::fingerprint() const {
  uint64_t hash = 0;
  const auto add = [&](const Node& node) {
    for (const Lanes* lanes : {&node.x, &node.y, &node.z, &node.radius, &node.intensity})
      for (const float v : *lanes) hash = hash_combine(hash, std::bit_cast<uint32_t>(v));
  };
  add(nodes_[0]);
  for (const uint32_t child : nodes_[0].child)
    if (child != kNoChild && !(child & kLight)) add(nodes_[child]);
  return hash;
}

size_t LightTree::size_bytes() const {
  return nodes_.size() * sizeof(Node) + slot_of_light_.size() * sizeof(uint32_t);
}

// Splits clusters by the surface area and orientation heuristic, the largest first, until a node
// has all its children.
struct LightTree::Builder {
  struct Item {
    LightBounds bounds;
    uint32_t light;
  };
  struct Range {
    size_t begin, end;
    size_t count() const { return end - begin; }
  };
  // A cluster while it is made: everything here adds up.
  struct Sum {
    Bounds3 box;
    Vec3 axis;  // times intensity; of two-sided lights toward the side of the first
    float intensity = 0;
    size_t count = 0;
    void add(const LightBounds& b, Vec3 first_axis) {
      box.add(b.box.lo);
      box.add(b.box.hi);
      const float sign = b.two_sided && dot(b.axis, first_axis) < 0 ? -1.0f : 1.0f;
      axis = axis + b.axis * (sign * b.intensity * (b.cos_spread <= -1 ? 0 : 1));
      intensity += b.intensity;
      ++count;
    }
    void add(const Sum& s) {
      if (s.count == 0) return;
      box.add(s.box.lo);
      box.add(s.box.hi);
      axis = axis + s.axis;
      intensity += s.intensity;
      count += s.count;
    }
    // How much its lights may differ: by their places, and by their directions.
    float cost() const {
      if (count == 0) return 0;
      const Vec3 e = box.hi - box.lo;
      const float alike = intensity > 0 ? std::min(length(axis) / intensity, 1.0f) : 1.0f;
      return intensity * (dot(e, e) + kTiny) * (4 - 3 * alike);
    }
  };

  LightTree& tree;
  std::vector<Item> items;

  Vec3 first_axis(Range r) const { return items[r.begin].bounds.axis; }
  static Vec3 center(const LightBounds& b) { return (b.box.lo + b.box.hi) * 0.5f; }

  Sum sum(Range r) const {
    Sum s;
    const Vec3 first = first_axis(r);
    for (size_t i = r.begin; i < r.end; ++i) s.add(items[i].bounds, first);
    return s;
  }

  struct Cluster {
    Range range;
    Sum sum;
  };
  Cluster cluster(Range r) const { return {r, sum(r)}; }

  // Where the second half begins.
  size_t split(const Cluster& c, int depth) {
    constexpr int kBins = 12, kDeep = 48;
    constexpr size_t kMany = 4096;  // along the longest axis alone
    const Range r = c.range;
    const size_t middle = r.begin + r.count() / 2;
    Bounds3 centers;
    for (size_t i = r.begin; i < r.end; ++i) centers.add(center(items[i].bounds));
    const Vec3 extent = centers.hi - centers.lo;
    const float longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0) || depth > kDeep) return middle;
    const Vec3 first = first_axis(r);
    float best_cost = std::numeric_limits<float>::infinity();
    int best_axis = -1, best_bin = 0;
    const auto bin_of = [&](const LightBounds& b, int axis) {
      const float t = (center(b)[axis] - centers.lo[axis]) / extent[axis];
      return std::clamp(static_cast<int>(t * kBins), 0, kBins - 1);
    };
    for (int axis = 0; axis < 3; ++axis) {
      if (!(extent[axis] > (r.count() > kMany ? 0.999f : 0.1f) * longest)) continue;
      std::array<Sum, kBins> bins;
      for (size_t i = r.begin; i < r.end; ++i)
        bins[static_cast<size_t>(bin_of(items[i].bounds, axis))].add(items[i].bounds, first);
      std::array<float, kBins> above{};
      Sum up, down;
      for (size_t b = kBins - 1; b > 0; --b) {
        up.add(bins[b]);
        above[b] = up.cost();
      }
      for (size_t b = 1; b < kBins; ++b) {
        down.add(bins[b - 1]);
        if (down.count == 0 || down.count == r.count()) continue;
        const float cost = down.cost() + above[b];
        if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = static_cast<int>(b);
      }
    }
    if (best_axis < 0) return middle;
    const auto at =
        std::partition(items.begin() + static_cast<ptrdiff_t>(r.begin),
                       items.begin() + static_cast<ptrdiff_t>(r.end),
                       [&](const Item& item) { return bin_of(item.bounds, best_axis) < best_bin; });
    return static_cast<size_t>(at - items.begin());
  }

  // What bounds all of them.
  LightBounds bound(const Cluster& c) const {
    const Sum& s = c.sum;
    const Range r = c.range;
    LightBounds all{.box = s.box, .intensity = s.intensity};
    const float axis_length = length(s.axis);
    const bool points = axis_length > kTiny;
    if (points) all.axis = s.axis / axis_length;
    all.cos_emission = 1;
    all.cos_spread = points ? 1.0f : -1.0f;
    for (size_t i = r.begin; i < r.end; ++i) {
      const LightBounds& b = items[i].bounds;
      all.two_sided |= b.two_sided;
      all.cos_emission = std::min(all.cos_emission, b.cos_emission);
      float cos_axes = std::clamp(dot(b.axis, all.axis), -1.0f, 1.0f);
      if (b.two_sided) cos_axes = std::abs(cos_axes);
      if (b.cos_spread < 1) {  // to the farthest that this one shines
        const float sin_axes = std::sqrt(1 - cos_axes * cos_axes);
        const float sin_o = std::sqrt(std::max(1 - b.cos_spread * b.cos_spread, 0.0f));
        cos_axes = cos_axes <= -b.cos_spread ? -1 : cos_axes * b.cos_spread - sin_axes * sin_o;
      }
      all.cos_spread = std::min(all.cos_spread, cos_axes);
    }
    return all;
  }

  void hang(uint32_t node, size_t lane, const LightBounds& b, uint32_t child) {
    Node& n = tree.nodes_[node];
    const Vec3 c = center(b), half = (b.box.hi - b.box.lo) * 0.5f;
    n.x[lane] = c.x, n.y[lane] = c.y, n.z[lane] = c.z;
    n.radius[lane] = length(half) * (1 + kSlack);
    n.over_radius2[lane] = 1 / sqr(n.radius[lane]);  // of a point infinite
    n.axis_x[lane] = b.axis.x, n.axis_y[lane] = b.axis.y, n.axis_z[lane] = b.axis.z;
    n.cos_spread[lane] = b.cos_spread;
    n.sin_spread[lane] = std::sqrt(std::max(1 - b.cos_spread * b.cos_spread, 0.0f));
    n.cos_emission[lane] = b.cos_emission - kSlack;
    n.two_sided[lane] = b.two_sided ? 1.0f : 0.0f;
    n.intensity[lane] = b.intensity;
    n.child[lane] = child;
  }

  // At most kLanes of them. Those that fit into a node of their own are not split, but taken apart
  // while there is room.
  std::vector<Cluster> children_of(const Cluster& whole, int depth) {
    std::vector<Cluster> children{whole};
    const auto worth = [](const Cluster& c) {
      return c.range.count() > kLanes ? c.sum.cost() : -1.0f;
    };
    while (children.size() < kLanes) {
      const auto widest = std::ranges::max_element(children, {}, worth);
      if (widest->range.count() <= kLanes) break;
      const Range r = widest->range;
      const size_t at = split(*widest, depth);
      *widest = cluster({r.begin, at});
      children.push_back(cluster({at, r.end}));
    }
    for (size_t i = 0; i < children.size();) {
      const Range r = children[i].range;
      if (r.count() == 1 || children.size() - 1 + r.count() > kLanes) {
        ++i;
        continue;
      }
      children.erase(children.begin() + static_cast<ptrdiff_t>(i));
      for (size_t j = r.begin; j < r.end; ++j) children.push_back(cluster({j, j + 1}));
    }
    return children;
  }

  uint32_t build(const Cluster& whole, uint32_t parent, int depth) {
    const uint32_t node = static_cast<uint32_t>(tree.nodes_.size());
    tree.nodes_.emplace_back().parent = parent;
    const std::vector<Cluster> children = children_of(whole, depth);
    for (size_t lane = 0; lane < children.size(); ++lane) {
      const Cluster& c = children[lane];
      const uint32_t slot = node * static_cast<uint32_t>(kLanes) + static_cast<uint32_t>(lane);
      if (c.range.count() == 1) {
        const Item& item = items[c.range.begin];
        tree.slot_of_light_[item.light] = slot;
        hang(node, lane, item.bounds, item.light | kLight);
      } else {
        const LightBounds bounds = bound(c);
        hang(node, lane, bounds, build(c, slot, depth + 1));
      }
    }
    return node;
  }
};

LightTree::LightTree(std::span<const LightBounds> lights) : slot_of_light_(lights.size()) {
  Builder builder{*this, {}};
  builder.items.reserve(lights.size());
  for (uint32_t i = 0; i < lights.size(); ++i) builder.items.push_back({lights[i], i});
  nodes_.reserve(lights.size() / 4 + 1);
  builder.build(builder.cluster({0, lights.size()}), 0, 0);
  nodes_.shrink_to_fit();
  uint32_t next = kLanes;
  for (size_t lane = 0; lane < kLanes; ++lane)
    if (const uint32_t child = nodes_[0].child[lane]; child != kNoChild && !(child & kLight))
      first_below_[lane] = std::exchange(next, next + static_cast<uint32_t>(kLanes));
}

}  // namespace qray
