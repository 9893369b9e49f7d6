#include "core/render/caustic_map.h"

#include <algorithm>
#include <cmath>

#include "core/math/frame.h"
#include "core/math/ray.h"

namespace qray {
namespace {

constexpr int kCodeBits = 21;  // an axis
constexpr int kDeepest = kCodeBits - 1;
constexpr size_t kSplitPhotons = 2 * CausticMap::kLobes;
constexpr float kMostAimed = 0.6f;
// Where aiming gains less and yet something: the brightest pixels are of light that paths find by
// chance in such places.
constexpr float kSmallShare = 0.05f;
// The noise of all other light that directions find, of what arrives where light does.
constexpr float kOtherNoise = 0.3f;
// By how much aiming must lower the second moment. What is expected of it is more than what comes
// of it: docs/measurements/caustics.md.
constexpr float kLeastGainOfAiming = 8;
// Of the photons, that must have arrived where it does.
constexpr double kLeastGaining = 0.02;
constexpr float kNarrowest = 2e-6f;  // of a lobe: half its squared angle

uint64_t with_gaps(uint64_t v) {  // two zero bits after each
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

uint64_t morton_code(Vec3 unit) {
  const auto whole = [](float v) {
    return static_cast<uint64_t>(std::clamp(v * 0x1p21f, 0.0f, 0x1.fffffep20f));
  };
  return with_gaps(whole(unit.x)) | with_gaps(whole(unit.y)) << 1 | with_gaps(whole(unit.z)) << 2;
}

// s: half the squared angle that its radius is seen at, at most half.
float lobe_width(float radius, float distance2) {
  const float r2 = sqr(radius);
  return kNarrowest + 0.5f * r2 / (distance2 + r2);
}

float distance2_to(const CausticMap::Lobes& l, size_t lobe, Vec3 p) {
  const Vec3 to = Vec3{l.x[lobe], l.y[lobe], l.z[lobe]} - p;
  return dot(to, to) + 1e-12f;
}

CausticMap::Lobes lobes_of(std::span<const CausticPhoton> photons, float side) {
  constexpr size_t kNeighbour = 3;
  constexpr float kOfNeighbour = 0.5f, kOfSide = 0.25f;
  CausticMap::Lobes lobes;
  std::array<Vec3, CausticMap::kLobes> from;
  for (size_t i = 0; i < from.size(); ++i)
    from[i] = photons[(2 * i + 1) * photons.size() / (2 * from.size())].from;
  for (size_t i = 0; i < from.size(); ++i) {
    std::array<float, CausticMap::kLobes> distances;
    for (size_t j = 0; j < from.size(); ++j) distances[j] = length(from[j] - from[i]);
    std::ranges::nth_element(distances, distances.begin() + kNeighbour);
    lobes.x[i] = from[i].x, lobes.y[i] = from[i].y, lobes.z[i] = from[i].z;
    lobes.radius[i] = kOfNeighbour * distances[kNeighbour] + kOfSide * side;
  }
  return lobes;
}

}  // namespace

struct CausticMap::Builder {
  CausticMap& map;
  std::vector<uint64_t> codes;
  std::vector<CausticPhoton> photons;  // parallel, by code
  double share_of_one = 0;             // of all light
  double usual = 0;  // of all light, what arrives on a square metre where any does

  // body(begin, end) of each octant of a cell of sorted codes.
  template <class Body>
  static void for_each_octant(std::span<const uint64_t> codes, size_t begin, size_t end, int depth,
                              Body body) {
    const int shift = 3 * (kDeepest - depth);
    for (unsigned octant = 0; octant < 8; ++octant) {
      const size_t from = begin;
      while (begin < end && (codes[begin] >> shift & 7) == octant) ++begin;
      body(octant, from, begin);
    }
  }

  // Square metres of the cells that hold the points, each cell with few of them.
  double area(std::span<const uint64_t> points, size_t begin, size_t end, int depth) const {
    if (begin == end) return 0;
    if (end - begin < kSplitPhotons || depth >= kDeepest)
      return double{sqr(std::ldexp(map.side_, -depth))};
    double sum = 0;
    for_each_octant(points, begin, end, depth, [&](unsigned, size_t from, size_t to) {
      sum += area(points, from, to, depth + 1);
    });
    return sum;
  }

  // By how much the lobes are denser than a cosine where the photons came from.
  float ratio(const Lobes& lobes, size_t begin, size_t end) const {
    float sum = 0;
    for (size_t i = 0; i < kLobes; ++i) {
      const CausticPhoton& photon = photons[begin + i * (end - begin) / kLobes];
      const Vec3 to = photon.from - photon.p;
      const float distance = length(to);
      if (distance > 0) sum += pdf_w(lobes, photon.p, to / distance);
    }
    return sum / kLobes * (2 * kPi);
  }

  // Sets the node's share by second moments, in units of what all other light has. If all paths
  // aimed, the light by way of mirrors and glass would have noise^2; without aiming it has as much
  // more as lobes are denser than a cosine.
  void decide(Node& node, size_t begin, size_t end, float side) const {
    const double here = static_cast<double>(end - begin) * share_of_one / double{sqr(side)};
    const double noise = here / (usual * double{kOtherNoise});
    const double denser = double{ratio(node.lobes, begin, end)};
    const double unaimed = noise * noise * denser;
    // The best split between two sources of noise is in proportion to them.
    const double aimed = (noise + 1) * (noise + 1);
    const double aimed_little =
        unaimed / (1 + double{kSmallShare} * denser) + 1 / (1 - double{kSmallShare});
    node.gains = unaimed + 1 > double{kLeastGainOfAiming} * aimed;
    if (node.gains) node.share = kMostAimed * static_cast<float>(noise / (noise + 1));
    if (unaimed + 1 > aimed_little) node.share = std::max(node.share, kSmallShare);
  }

  uint32_t build(size_t begin, size_t end, int depth) {
    const auto index = static_cast<uint32_t>(map.nodes_.size());
    const float side = std::ldexp(map.side_, -depth);
    {
      Node& node = map.nodes_.emplace_back();
      node.lobes = lobes_of(std::span(photons).subspan(begin, end - begin), side);
      decide(node, begin, end, side);
    }
    if (end - begin >= kSplitPhotons && depth < kDeepest)
      for_each_octant(codes, begin, end, depth, [&](unsigned octant, size_t from, size_t to) {
        if (to - from < kLobes) return;
        const uint32_t child = build(from, to, depth + 1);
        map.nodes_[index].child[octant] = child;
      });
    return index;
  }
};

CausticMap::CausticMap(const CausticPhotons& traced) {
  if (traced.photons.size() < kLobes) return;
  Bounds3 bounds;
  for (const CausticPhoton& photon : traced.photons) bounds.add(photon.p);
  for (const Vec3 p : traced.arrivals) bounds.add(p);
  lo_ = bounds.lo;
  const Vec3 extent = bounds.extent();
  side_ = std::max({extent.x, extent.y, extent.z, 1e-6f}) * 1.0001f;
  const auto code_of = [&](Vec3 p) { return morton_code((p - lo_) / side_); };

  Builder builder{*this, {}, {}};
  std::vector<uint64_t> arrivals;
  for (const Vec3 p : traced.arrivals) arrivals.push_back(code_of(p));
  std::ranges::sort(arrivals);
  builder.usual = static_cast<double>(arrivals.size()) * traced.arrival_share /
                  builder.area(arrivals, 0, arrivals.size(), 0);
  builder.share_of_one = traced.share / static_cast<double>(traced.photons.size());
  std::vector<std::pair<uint64_t, uint32_t>> order;
  for (uint32_t i = 0; i < traced.photons.size(); ++i)
    order.emplace_back(code_of(traced.photons[i].p), i);
  std::ranges::sort(order);
  for (const auto& [code, i] : order) {
    builder.codes.push_back(code);
    builder.photons.push_back(traced.photons[i]);
  }
  builder.build(0, order.size(), 0);
  const auto gaining = std::ranges::count_if(
      traced.photons, [&](const CausticPhoton& photon) { return node_at(photon.p)->gains; });
  if (static_cast<double>(gaining) < kLeastGaining * static_cast<double>(traced.photons.size()))
    nodes_.clear();
}

CausticMap::Place CausticMap::find(Vec3 p) const {
  const Node* node = node_at(p);
  return node ? Place{&node->lobes, node->share} : Place{};
}

const CausticMap::Node* CausticMap::node_at(Vec3 p) const {
  Vec3 at = (p - lo_) / side_;
  if (!(at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < 1 && at.y < 1 && at.z < 1)) return nullptr;
  const Node* node = &nodes_[0];
  for (;;) {
    at = at * 2;
    const unsigned x = at.x >= 1 ? 1 : 0, y = at.y >= 1 ? 1 : 0, z = at.z >= 1 ? 1 : 0;
    const uint32_t child = node->child[x | y << 1 | z << 2];
    if (child == 0) return node;
    at = at - Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    node = &nodes_[child];
  }
}

Vec3 CausticMap::sample(const Lobes& lobes, Vec3 p, Vec2 u) {
  const float scaled = u.x * kLobes;
  const size_t lobe = std::min(static_cast<size_t>(scaled), kLobes - 1);
  const float rest = scaled - static_cast<float>(lobe);
  const float d2 = distance2_to(lobes, lobe, p), s = lobe_width(lobes.radius[lobe], d2);
  const float c = rest * (2 / (s + 2));
  const float height = std::min(s * c / (1 - c), 2.0f);  // 1 - cosine
  const float sine = std::sqrt(std::max(height * (2 - height), 0.0f)), phi = 2 * kPi * u.y;
  const Vec3 axis = normalize(Vec3{lobes.x[lobe], lobes.y[lobe], lobes.z[lobe]} - p);
  return normalize(Frame(axis).to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - height}));
}

float CausticMap::pdf_w(const Lobes& l, Vec3 p, Vec3 wi) {
  // Without branches and summed in pairs: compilers make vectors of it.
  std::array<float, kLobes> of_lobe;
  for (size_t i = 0; i < kLobes; ++i) {
    const float x = l.x[i] - p.x, y = l.y[i] - p.y, z = l.z[i] - p.z;
    const float d2 = x * x + y * y + z * z + 1e-12f, over_d = 1 / std::sqrt(d2);
    const float s = lobe_width(l.radius[i], d2);
    // 1 - cosine, without its rounding
    const float dx = x * over_d - wi.x, dy = y * over_d - wi.y, dz = z * over_d - wi.z;
    const float height = 0.5f * (dx * dx + dy * dy + dz * dz);
    of_lobe[i] = (s + 2) * s / sqr(s + height);
  }
  for (size_t half = kLobes / 2; half > 0; half /= 2)
    for (size_t i = 0; i < half; ++i) of_lobe[i] += of_lobe[i + half];
  return of_lobe[0] / (4 * kPi * kLobes);
}

}  // namespace qray
