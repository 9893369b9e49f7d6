#include "core/guide/ppg.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>

#include "core/guide/ppg_layout.h"
#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr double kRadianceOne = 0x1p32;  // of radiance_unit_, in fixed point
constexpr float kSplitSamples = 4000;    // c, of the spatial tree's c sqrt(2^k)
constexpr DirectionParams kDirection{
    .shrinkage = 0, .split_share = 0.01f, .min_split_gain = -1, .max_depth = PpgRecord::kMaxDepth};
// Adam (Kingma and Ba 2015), with the course notes' rate and regularisation.
constexpr float kRate = 0.01f, kBeta1 = 0.9f, kBeta2 = 0.999f, kRegular = 0.01f;

Vec3 to_direction(Vec2 u) {
  const float z = 2 * u.x - 1, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
Vec2 to_square(Vec3 w) {
  const float phi = std::atan2(w.y, w.x) * (0.5f * kInvPi);
  return {std::clamp(0.5f * (w.z + 1), 0.0f, kOneMinusEpsilon),
          std::clamp(phi < 0 ? phi + 1 : phi, 0.0f, kOneMinusEpsilon)};
}

// Numbers in [-1/2, 1/2) from what is being splatted, so that they depend on no thread.
struct Jitter {
  uint64_t bits;
  float next() {
    bits = mix64(bits);
    return to_unit_float(static_cast<uint32_t>(bits >> 32)) - 0.5f;
  }
};
uint64_t bits_of(Vec3 v) {
  return mix64(std::bit_cast<uint32_t>(v.x) ^
               mix64(std::bit_cast<uint32_t>(v.y) ^ mix64(std::bit_cast<uint32_t>(v.z))));
}

}  // namespace

struct PpgGuide::Delta final : GuideDelta {
  struct Event {
    uint32_t leaf;
    float gradient;  // of the KL divergence, by theta
  };
  std::vector<Event> events;
};

PpgGuide::PpgGuide(const GuideSetup& setup)
    : max_bytes_(setup.max_bytes),
      radiance_unit_(std::max(static_cast<double>(setup.brightest_light), 1e-30)),
      tree_(setup.bounds) {
  DirectionTrees::Cells cells = DirectionTrees::one_cell();
  DirectionTrees::adapt(cells, kDirection);
  leaves_.emplace_back().root = directions_.put(cells);
}

GuidePoint PpgGuide::point_of(uint32_t leaf) const {
  return {StateId(leaf), tree_.key(leaf), Frame({1, 0, 0}, {0, 1, 0}, {0, 0, 1}),
          GuideDomain::kSphere};
}

GuidePoint PpgGuide::find(Vec3 p, Vec3 n) const {
  const uint32_t leaf = tree_.leaf_at(tree_.beside(p, n));
  return point_of(leaf);
}

GuideMixture PpgGuide::mixture(const GuidePoint& point, const GuidedSurface&) const {
  const Leaf& leaf = leaves_[point.state.value];
  return GuideMixture::of(leaf.ready ? leaf.fraction : 0);
}

GuideSample PpgGuide::sample(const GuidePoint& point, Vec2 u) const {
  float density;
  const Vec2 square = directions_.sample(leaves_[point.state.value].root, u, density);
  return {to_direction(square), density * kUniformSpherePdfW};
}

float PpgGuide::pdf_w(const GuidePoint& point, Vec3 wi) const {
  return directions_.pdf(leaves_[point.state.value].root, to_square(wi)) * kUniformSpherePdfW;
}

float PpgGuide::gain(const GuidePoint& point) const {
  const Leaf& leaf = leaves_[point.state.value];
  return leaf.ready ? static_cast<float>(directions_.second_moment(leaf.root)) : 1;
}

std::vector<DirectionCell> PpgGuide::directions(const GuidePoint& point) const {
  std::vector<DirectionCell> cells;
  const auto tree = directions_.take(leaves_[point.state.value].root);
  for (const DirectionTrees::Leaf& leaf : DirectionTrees::leaves(tree)) {
    const Vec2 middle = leaf.corner + Vec2{leaf.size / 2, leaf.size / 2};
    cells.push_back({to_direction(middle), static_cast<float>(leaf.mean) * kUniformSpherePdfW,
                     leaf.corner, leaf.size});
  }
  return cells;
}

// How often it was visited is known of the running iteration alone.
StateSummary PpgGuide::summary(const GuidePoint& point) const {
  return {max_component(tree_.extent(point.state.value)), std::nullopt};
}

std::unique_ptr<GuideDelta> PpgGuide::make_delta() const { return std::make_unique<Delta>(); }

void PpgGuide::record(std::span<const GuideVertex> path, GuideDelta& delta) const {
  for (const GuideVertex& v : path) {
    if (!v.guidable || !(v.pdf_w > 0)) continue;
    const Leaf& at = leaves_[v.at.state.value];
    const double paid = luminance(v.arriving) / v.pdf_w / radiance_unit_;
    if (!(paid < kMaxPaid)) continue;  // NaN too
    // 1. The radiance, into a leaf nearby and a direction nearby.
    Jitter jitter{bits_of(v.p) ^ mix64(bits_of(v.wi))};
    const Vec3 size = tree_.extent(v.at.state.value);
    const Leaf& leaf = leaves_[tree_.leaf_at(
        v.p + Vec3{size.x * jitter.next(), size.y * jitter.next(), size.z * jitter.next()})];
    Vec2 u = to_square(v.wi);
    const float width = directions_.cell_size(leaf.root, u);
    u.x = std::clamp(u.x + width * jitter.next(), 0.0f, kOneMinusEpsilon);
    u.y += width * jitter.next();
    u.y = std::min(u.y - std::floor(u.y), kOneMinusEpsilon);
    {
      const std::lock_guard guard(leaf.lock);
      directions_.add(leaf.root, u, static_cast<int64_t>(paid * kRadianceOne));
    }
    // 2. How the chance of the guide should change.
    float gradient = 0;
    if (at.ready && at.paid > 0) {  // in units of what the place is usually paid
      const float guide_pdf_w = pdf_w(v.at, v.wi);
      const float product =
          v.bsdf.f_cos * luminance(v.arriving) / (static_cast<float>(radiance_unit_) * at.paid);
      gradient = -product * (guide_pdf_w - v.bsdf.pdf_w) / (v.pdf_w * v.pdf_w) * at.fraction *
                 (1 - at.fraction);
    }
    static_cast<Delta&>(delta).events.push_back({v.at.state.value, gradient});
  }
}

void PpgGuide::step(Leaf& leaf, float gradient) {
  gradient += kRegular * leaf.theta;
  ++leaf.steps;
  leaf.first_moment = kBeta1 * leaf.first_moment + (1 - kBeta1) * gradient;
  leaf.second_moment = kBeta2 * leaf.second_moment + (1 - kBeta2) * gradient * gradient;
  const float steps = static_cast<float>(leaf.steps);
  const float first = leaf.first_moment / (1 - std::pow(kBeta1, steps));
  const float second = leaf.second_moment / (1 - std::pow(kBeta2, steps));
  leaf.theta -= kRate * first / (std::sqrt(second) + 1e-8f);
  leaf.theta = std::clamp(leaf.theta, -PpgRecord::kMaxTheta, PpgRecord::kMaxTheta);
}

void PpgGuide::update(GuideDelta& delta) {
  auto& events = static_cast<Delta&>(delta).events;
  for (const Delta::Event& e : events) {
    Leaf& leaf = leaves_[e.leaf];
    ++leaf.samples;
    if (leaf.ready && std::isfinite(e.gradient)) step(leaf, e.gradient);
  }
  iteration_samples_ += static_cast<int64_t>(events.size());
  samples_seen_ += events.size();
  events.clear();
}

void PpgGuide::end_pass() {
  for (Leaf& leaf : leaves_) leaf.fraction = 1 / (1 + std::exp(-leaf.theta));
  if (iteration_samples_ == 0 || iteration_samples_ < 2 * last_iteration_samples_) return;
  last_iteration_samples_ = iteration_samples_;
  iteration_samples_ = 0;
  // 1. Space: leaves with too many samples are cut, and cut again.
  const float most = kSplitSamples * std::exp2(0.5f * static_cast<float>(iteration_++));
  tree_.index_top(0);
  const size_t taken = bytes(), allowed = max_bytes_ - max_bytes_ / 8;  // the rest: the index
  const bool fits = taken <= max_bytes_;
  size_t room = allowed > taken ? allowed - taken : 0;
  for (uint32_t i = 0; i < leaves_.size(); ++i) {
    while (static_cast<float>(leaves_[i].samples) > most &&
           tree_.depth(i) < SpatialTree::kMaxDepth) {
      const size_t half = sizeof(Leaf) + SpatialTree::kMaxLeafBytes +
                          DirectionTrees::bytes_of(directions_.take(leaves_[i].root));
      if (half > room) {
        ++refused_;
        break;
      }
      room -= half;
      tree_.split(i);
      leaves_[i].samples /= 2;
      leaves_.push_back(Leaf(leaves_[i]));
    }
  }
  // 2. Directions: what this iteration learned is what the next one samples.
  DirectionTrees next;
  next.reserve(directions_.nodes());
  for (Leaf& leaf : leaves_) {
    DirectionTrees::Cells cells = directions_.take(leaf.root);
    if (const DirectionTrees::Sums all = DirectionTrees::total(cells); all.s > 0) {
      leaf.paid = static_cast<float>(static_cast<double>(all.s) / kRadianceOne / all.n);
      const size_t before = DirectionTrees::bytes_of(cells);
      const bool may_grow = 4 * before <= room;  // each leaf into four: less than 5 times as much
      refused_ += !may_grow;
      if (fits) DirectionTrees::estimate(cells, kDirection.shrinkage);
      if (may_grow) {
        DirectionTrees::adapt(cells, kDirection);
        room = room + before - DirectionTrees::bytes_of(cells);
      }
      leaf.ready = leaf.ready || fits;
    }
    DirectionTrees::scale(cells, 0, 1);
    leaf.root = next.put(cells);
    leaf.samples = 0;
  }
  directions_ = std::move(next);
  index();
}

void PpgGuide::index() {
  directions_.shrink();
  leaves_.shrink_to_fit();
  tree_.index_within(max_bytes_, bytes() - tree_.bytes());
}

size_t PpgGuide::bytes() const {
  return directions_.bytes() + leaves_.capacity() * sizeof(Leaf) + tree_.bytes();
}

// A tree that nothing was learned into is no table.
GuideStats PpgGuide::stats() const {
  const auto ready =
      std::count_if(leaves_.begin(), leaves_.end(), [](const Leaf& leaf) { return leaf.ready; });
  return {static_cast<size_t>(ready), directions_.nodes(), ready > 0 ? bytes() : 0, samples_seen_,
          refused_};
}

std::vector<GuidePoint> PpgGuide::known_points(size_t most) const {
  std::vector<GuidePoint> points;
  for (uint32_t i = 0; i < leaves_.size(); ++i)
    if (leaves_[i].ready) points.push_back(point_of(i));
  return spread_over(std::move(points), most);
}

template <class Self, class Archive>
void PpgGuide::exchange_state(Self& self, Archive& archive) {
  archive(self.tree_, self.leaves_, self.directions_, self.iteration_samples_,
          self.last_iteration_samples_, self.iteration_, self.samples_seen_, self.refused_);
}

void PpgGuide::save_state(SnapshotWriter& out) const { exchange_state(*this, out); }

void PpgGuide::load_state(SnapshotReader& in) { exchange_state(*this, in); }

}  // namespace qray
