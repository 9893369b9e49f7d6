#include "core/guide/huang.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/guide/gain.h"
#include "core/guide/grid_table.h"
#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr uint32_t kNormalMask = (1u << 30) - 1;

constexpr size_t kDirtyBytes = 1 + 2 * sizeof(uint32_t);
// A normal's shares in their map: the entry, its links, its hash bucket.
constexpr size_t kShareBytes = sizeof(std::pair<const uint32_t, HuangGuide::Values>) + 28;

// To `size` elements: room is doubled as push_back does, but for no more than `max_size`.
template <class T>
void grow(std::vector<T>& v, size_t size, size_t max_size) {
  if (size > v.capacity()) v.reserve(std::min(max_size, std::max<size_t>(2 * v.size(), 64)));
  v.resize(size);
}

// How many of the thresholds M/8, 2M/8 .. 7M/8 the value exceeds.
uint8_t level_of(float q, float max_q) {
  uint8_t level = 0;
  while (level < 7 && q > static_cast<float>(level + 1) * 0.125f * max_q) ++level;
  return level;
}

}  // namespace

struct HuangGuide::Delta final : GuideDelta {
  struct Transition {
    uint64_t state;
    uint64_t next;  // kNowhere: the path left the scene
    float reward;
    uint32_t action;
  };
  static constexpr uint64_t kNowhere = ~uint64_t{0};
  std::vector<Transition> transitions;
};

HuangGuide::HuangGuide(Density density, const Bounds3& bounds, const HuangParams& params,
                       size_t max_bytes)
    : density_(density), params_(params), grid_(bounds, params.grid), max_bytes_(max_bytes) {
  // The most that a state may take: its records, a normal of its own, its places in both indices.
  constexpr size_t kStateBytes =
      sizeof(Learned) + sizeof(Frozen) + kDirtyBytes + kShareBytes + 2 * KeyIndex::kMaxBytesPerKey;
  constexpr size_t kEmptyBytes = 2 * KeyIndex::kMinBytes;
  max_states_ = max_bytes > kEmptyBytes ? (max_bytes - kEmptyBytes) / kStateBytes : 0;
}

std::string_view HuangGuide::method() const {
  return density_ == Density::kExact ? "huang" : "huang-published";
}

GuidePoint HuangGuide::find(Vec3 p, Vec3 n) const {
  const SurfaceGrid::State s = grid_.state_at(p, n);
  return {frozen_index_.find(s.key), s.key, Frame(s.n)};
}

GuideMixture HuangGuide::mixture(const GuidePoint&, const GuidedSurface& surface) const {
  if (surface.base_chance == 1) return GuideMixture::of(1);
  return GuideMixture::of(density_ == Density::kExact ? 0.5f : 0);  // the thesis has Lambert only
}

GuideSample HuangGuide::sample(const GuidePoint& point, Vec2 u) const {
  const Frame& frame = point.frame;
  if (!point.state.valid()) {
    return {frame.to_world(square_to_uniform_hemisphere(u)), kUniformHemispherePdfW};
  }
  const Frozen& state = frozen_[point.state.value];
  // The first draw keeps u's stratification; the others need independent numbers.
  uint64_t bits =
      static_cast<uint64_t>(std::bit_cast<uint32_t>(u.x)) << 32 | std::bit_cast<uint32_t>(u.y);
  for (int i = 7;; --i) {
    const Vec3 d = frame.to_world(square_to_uniform_hemisphere(u));
    const size_t a = static_cast<size_t>(nearest_direction26(d));
    if (i == 1 || state.level[a] >= i) {
      const float weight = density_ == Density::kExact ? state.weight[a] : 1.0f;
      return {d, weight * kUniformHemispherePdfW};
    }
    bits = mix64(bits);
    u = {to_unit_float(static_cast<uint32_t>(bits >> 32)),
         to_unit_float(static_cast<uint32_t>(bits))};
  }
}

float HuangGuide::pdf_w(const GuidePoint& point, Vec3 wi) const {
  if (!point.covers(wi)) return 0;
  if (!point.state.valid() || density_ == Density::kAsPublished) return kUniformHemispherePdfW;
  const size_t a = static_cast<size_t>(nearest_direction26(wi));
  return frozen_[point.state.value].weight[a] * kUniformHemispherePdfW;
}

float HuangGuide::gain(const GuidePoint& point) const {
  return point.state.valid() ? frozen_[point.state.value].gain : 1;
}

std::vector<DirectionCell> HuangGuide::directions(const GuidePoint& point) const {
  std::vector<DirectionCell> cells;
  const Values shares = hemisphere_shares26(point.frame.z);
  for (size_t a = 0; a < shares.size() && point.state.valid(); ++a)
    if (shares[a] > 0)
      cells.push_back({directions26()[a],
                       frozen_[point.state.value].weight[a] * kUniformHemispherePdfW,
                       {},
                       0});
  return cells;
}

StateSummary HuangGuide::summary(const GuidePoint& point) const {
  const StateId learned = learned_index_.find(point.key);
  if (!learned.valid()) return {grid_.cell_m(), std::nullopt};
  const auto& count = learned_[learned.value].count;
  return {grid_.cell_m(), std::accumulate(count.begin(), count.end(), uint64_t{0})};
}

std::vector<GuidePoint> HuangGuide::known_points(size_t most) const {
  return points_of(frozen_index_, most);
}

std::unique_ptr<GuideDelta> HuangGuide::make_delta() const { return std::make_unique<Delta>(); }

void HuangGuide::record(std::span<const GuideVertex> path, GuideDelta& delta) const {
  auto& transitions = static_cast<Delta&>(delta).transitions;
  for (size_t i = 0; i < path.size(); ++i) {
    const GuideVertex& v = path[i];
    if (!v.guidable) continue;
    const uint64_t next =
        v.transition.lands && i + 1 < path.size() ? path[i + 1].at.key : Delta::kNowhere;
    transitions.push_back(
        {v.at.key, next, v.transition.emitted, static_cast<uint32_t>(nearest_direction26(v.wi))});
  }
}

StateId HuangGuide::learned_state(uint64_t key) {
  const StateId known = learned_index_.find(key);
  if (known.valid() || learned_.size() >= max_states_) return known;
  grow(learned_, learned_.size() + 1, max_states_);
  grow(is_dirty_, learned_.size(), max_states_);
  return learned_index_.find_or_insert(key);
}

void HuangGuide::mark(StateId state) {
  if (is_dirty_[state.value]) return;
  is_dirty_[state.value] = 1;
  dirty_.push_back(state.value);
}

void HuangGuide::update(GuideDelta& delta) {
  auto& transitions = static_cast<Delta&>(delta).transitions;
  for (const Delta::Transition& t : transitions) {
    const StateId id = learned_state(t.state);
    if (!id.valid()) {
      ++refused_;
      continue;
    }
    float future = 0;
    if (t.next != Delta::kNowhere) {
      if (const Values* next = values(t.next))
        future = *std::max_element(next->begin(), next->end());
    }
    Learned& state = learned_[id.value];
    float& q = state.q[t.action];
    q = (1 - params_.alpha) * q + params_.alpha * (t.reward + params_.gamma * future);
    uint32_t& count = state.count[t.action];
    if (count != ~0u) ++count;
    ++samples_seen_;
    mark(id);
  }
  transitions.clear();
}

const HuangGuide::Values& HuangGuide::shares_of(uint64_t key) {
  const auto [entry, inserted] = shares_.try_emplace(static_cast<uint32_t>(key & kNormalMask));
  if (inserted) entry->second = hemisphere_shares26(SurfaceGrid::normal_of(key));
  return entry->second;
}

HuangGuide::Values HuangGuide::density_weights(const Values& values, const Values& shares) {
  const float max_q = *std::max_element(values.begin(), values.end());
  std::array<uint8_t, kDirections26> level;
  for (size_t a = 0; a < level.size(); ++a) level[a] = level_of(values[a], max_q);
  // reach[k]: the chance that the draws with i = 7 .. k+1 were all refused (S_k).
  std::array<double, 8> reach;
  reach[7] = 1;
  for (size_t k = 6; k >= 1; --k) {
    double refused = 0;  // R_{k+1}
    for (size_t a = 0; a < level.size(); ++a)
      if (level[a] < k + 1) refused += shares[a];
    reach[k] = reach[k + 1] * refused;
  }
  Values weights;
  for (size_t a = 0; a < weights.size(); ++a) {
    double w = reach[1];
    for (size_t k = 2; k <= level[a]; ++k) w += reach[k];
    weights[a] = static_cast<float>(w);
  }
  return weights;
}

void HuangGuide::end_pass() {
  for (uint32_t i : dirty_) {
    is_dirty_[i] = 0;
    const uint64_t key = learned_index_.keys()[i];
    const StateId id = frozen_index_.find_or_insert(key);
    if (id.value >= frozen_.size()) grow(frozen_, id.value + 1, max_states_);
    const Values& q = learned_[i].q;
    const float max_q = *std::max_element(q.begin(), q.end());
    Frozen& state = frozen_[id.value];
    const Values& shares = shares_of(key);
    state.weight = density_weights(q, shares);
    state.gain = gain_of_cells(shares, q, state.weight);
    for (size_t a = 0; a < q.size(); ++a) state.level[a] = level_of(q[a], max_q);
  }
  dirty_.clear();
}

GuideStats HuangGuide::stats() const {
  return {learned_.size(), 0,
          learned_index_.bytes() + frozen_index_.bytes() + learned_.capacity() * sizeof(Learned) +
              frozen_.capacity() * sizeof(Frozen) + is_dirty_.capacity() +
              dirty_.capacity() * sizeof(uint32_t) + shares_.size() * kShareBytes,
          samples_seen_, refused_};
}

const HuangGuide::Values* HuangGuide::values(uint64_t key) const {
  const StateId id = learned_index_.find(key);
  return id.valid() ? &learned_[id.value].q : nullptr;
}

void HuangGuide::set_values(uint64_t key, const Values& values) {
  const StateId id = learned_state(key);
  QRAY_CHECK(id.valid());
  learned_[id.value].q = values;
  mark(id);
}

template <class Self, class Archive>
void HuangGuide::exchange_state(Self& self, Archive& archive) {
  archive(self.samples_seen_, self.refused_, self.learned_index_, self.learned_, self.is_dirty_,
          self.dirty_, self.frozen_index_, self.frozen_);
}

void HuangGuide::save_state(SnapshotWriter& out) const { exchange_state(*this, out); }

void HuangGuide::load_state(SnapshotReader& in) {
  exchange_state(*this, in);
  for (uint64_t key : frozen_index_.keys()) shares_of(key);
}

}  // namespace qray
