#include "core/guide/dahm_keller.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/guide/direction_tree.h"
#include "core/guide/gain.h"
#include "core/guide/grid_table.h"
#include "core/math/warp.h"

namespace qray {
namespace {

static_assert(kDahmKellerLayout.cells == DahmKellerGuide::kCells);
// Added to every cell, in means of the state's Q: the paper does not say how cells that were dark
// so far stay possible.
constexpr float kLeast = 0.25f;
// The rest is drawn from the BSDF, so that no surface multiplies a path's weight by more than 2
// albedo. With all drawn from Q it is 10 albedo, and over several bounces the mean of any picture
// rests on paths that it does not have (docs/measurements/guiding.md).
constexpr float kGuided = 0.5f;

// Means of cos(theta) over the cells: z of square_to_uniform_hemisphere(), integrated numerically.
const DahmKellerGuide::Values& mean_cosines() {
  static const DahmKellerGuide::Values cosines = [] {
    DahmKellerGuide::Values mean{};
    constexpr int kSide = DahmKellerGuide::kSide, kFine = 16;
    for (int y = 0; y < kSide * kFine; ++y)
      for (int x = 0; x < kSide * kFine; ++x) {
        constexpr float kStep = 1.0f / (kSide * kFine);
        const Vec3 d = square_to_uniform_hemisphere(
            {(static_cast<float>(x) + 0.5f) * kStep, (static_cast<float>(y) + 0.5f) * kStep});
        mean[static_cast<size_t>(y / kFine * kSide + x / kFine)] += d.z / (kFine * kFine);
      }
    return mean;
  }();
  return cosines;
}

float scattered_of(const DahmKellerGuide::Values& q) {
  float sum = 0;
  for (size_t k = 0; k < q.size(); ++k)
    sum += q[k] * mean_cosines()[k] * (2.0f / DahmKellerGuide::kCells);
  return sum;
}

}  // namespace

struct DahmKellerGuide::Delta final : GuideDelta {
  struct Transition {
    uint64_t state;
    uint64_t next;  // kNowhere: the path left the scene
    float emitted;
    float albedo;  // where the ray landed
    uint32_t cell;
  };
  static constexpr uint64_t kNowhere = ~uint64_t{0};
  std::vector<Transition> transitions;
};

DahmKellerGuide::DahmKellerGuide(const GuideSetup& setup)
    : grid_(setup.bounds, setup.huang.grid), max_bytes_(setup.max_bytes) {
  constexpr size_t kStateBytes =
      2 * (sizeof(Learned) + sizeof(Frozen) + sizeof(uint32_t)) + 2 * KeyIndex::kMaxBytesPerKey;
  constexpr size_t kEmptyBytes = 2 * KeyIndex::kMinBytes;
  max_states_ = max_bytes_ > kEmptyBytes ? (max_bytes_ - kEmptyBytes) / kStateBytes : 0;
}

GuidePoint DahmKellerGuide::find(Vec3 p, Vec3 n) const {
  const SurfaceGrid::State s = grid_.state_at(p, n);
  return {frozen_index_.find(s.key), s.key, Frame(s.n)};
}

GuideMixture DahmKellerGuide::mixture(const GuidePoint& point, const GuidedSurface&) const {
  return GuideMixture::of(point.state.valid() ? kGuided : 0);
}

// The inverse of square_to_uniform_hemisphere().
int DahmKellerGuide::cell_of(Vec3 local) {
  const float scale = 1 / std::sqrt(1 + std::max(local.z, 0.0f));
  const Vec2 u = disk_to_square({local.x * scale, local.y * scale});
  return static_cast<int>(u.y * kSide) * kSide + static_cast<int>(u.x * kSide);
}

GuideSample DahmKellerGuide::sample(const GuidePoint& point, Vec2 u) const {
  const auto& cdf = frozen_[point.state.value].cdf;
  const size_t cell =
      static_cast<size_t>(std::upper_bound(cdf.begin(), cdf.end() - 1, u.x) - cdf.begin());
  const float below = cell > 0 ? cdf[cell - 1] : 0, chance = cdf[cell] - below;
  // What u.x says beside the cell is the place within it along x.
  const float x = std::clamp((u.x - below) / chance, 0.0f, kOneMinusEpsilon);
  constexpr float kWidth = 1.0f / kSide;
  const Vec3 d = square_to_uniform_hemisphere({(static_cast<float>(cell % kSide) + x) * kWidth,
                                               (static_cast<float>(cell / kSide) + u.y) * kWidth});
  return {point.frame.to_world(d), chance * kCells * kUniformHemispherePdfW};
}

float DahmKellerGuide::pdf_w(const GuidePoint& point, Vec3 wi) const {
  const Vec3 local = point.frame.to_local(wi);
  if (local.z <= 0) return 0;
  const auto& cdf = frozen_[point.state.value].cdf;
  const size_t cell = static_cast<size_t>(cell_of(local));
  return (cdf[cell] - (cell > 0 ? cdf[cell - 1] : 0)) * kCells * kUniformHemispherePdfW;
}

float DahmKellerGuide::gain(const GuidePoint& point) const {
  return point.state.valid() ? frozen_[point.state.value].gain : 1;
}

std::vector<DirectionCell> DahmKellerGuide::directions(const GuidePoint& point) const {
  std::vector<DirectionCell> cells;
  constexpr float kSize = 1.0f / kSide;
  for (int k = 0; k < kCells && point.state.valid(); ++k) {
    const Vec2 corner = {static_cast<float>(k % kSide) * kSize,
                         static_cast<float>(k / kSide) * kSize};
    const Vec3 wi =
        point.frame.to_world(square_to_uniform_hemisphere(corner + Vec2{kSize / 2, kSize / 2}));
    cells.push_back({wi, pdf_w(point, wi), corner, kSize});
  }
  return cells;
}

StateSummary DahmKellerGuide::summary(const GuidePoint& point) const {
  const StateId learned = learned_index_.find(point.key);
  if (!learned.valid()) return {grid_.cell_m(), std::nullopt};
  const auto& visits = learned_[learned.value].visits;
  return {grid_.cell_m(), std::accumulate(visits.begin(), visits.end(), uint64_t{0})};
}

std::vector<GuidePoint> DahmKellerGuide::known_points(size_t most) const {
  return points_of(frozen_index_, most);
}

std::unique_ptr<GuideDelta> DahmKellerGuide::make_delta() const {
  return std::make_unique<Delta>();
}

void DahmKellerGuide::record(std::span<const GuideVertex> path, GuideDelta& delta) const {
  auto& transitions = static_cast<Delta&>(delta).transitions;
  for (size_t i = 0; i < path.size(); ++i) {
    const GuideVertex& v = path[i];
    if (!v.guidable) continue;
    const Vec3 local = v.at.frame.to_local(v.wi);
    if (local.z <= 0) continue;
    const bool lands = v.transition.lands && i + 1 < path.size();
    transitions.push_back({v.at.key, lands ? path[i + 1].at.key : Delta::kNowhere,
                           v.transition.emitted, lands ? path[i + 1].transition.albedo : 0,
                           static_cast<uint32_t>(cell_of(local))});
  }
}

DahmKellerGuide::Learned& DahmKellerGuide::learned_state(uint64_t key) {
  const StateId id = learned_index_.find_or_insert(key);
  if (id.value >= learned_.size()) learned_.emplace_back();
  Learned& state = learned_[id.value];
  if (!state.dirty) dirty_.push_back(id.value);
  state.dirty = true;
  return state;
}

void DahmKellerGuide::update(GuideDelta& delta) {
  auto& transitions = static_cast<Delta&>(delta).transitions;
  for (const Delta::Transition& t : transitions) {
    if (learned_.size() >= max_states_ && !learned_index_.find(t.state).valid()) {
      ++refused_;
      continue;
    }
    float target = t.emitted;
    if (t.next != Delta::kNowhere) {
      const StateId next = learned_index_.find(t.next);
      if (next.valid()) target += t.albedo * learned_[next.value].scattered;
    }
    if (!std::isfinite(target)) continue;
    Learned& state = learned_state(t.state);
    uint32_t& visits = state.visits[t.cell];
    const float change = (target - state.q[t.cell]) / (1 + static_cast<float>(visits));
    state.q[t.cell] += change;
    // Lambert's f cos: albedo / pi times cos over cells of 2 pi / 64.
    state.scattered =
        std::max(0.0f, state.scattered + change * mean_cosines()[t.cell] * (2.0f / kCells));
    if (visits != ~0u) ++visits;
    ++samples_seen_;
  }
  transitions.clear();
}

void DahmKellerGuide::freeze(uint32_t index) {
  const Learned& learned = learned_[index];
  const StateId id = frozen_index_.find_or_insert(learned_index_.keys()[index]);
  if (id.value >= frozen_.size()) frozen_.resize(id.value + 1);
  // Cells that were never drawn count as the mean of those that were.
  double sum = 0;
  int known = 0;
  for (size_t k = 0; k < kCells; ++k) {
    if (learned.visits[k] == 0) continue;
    sum += learned.q[k];
    ++known;
  }
  const double mean = sum > 0 ? sum / known : 1;
  double total = 0;
  std::array<double, kCells> below;
  Values means, weights, shares;
  shares.fill(1.0f / kCells);
  for (size_t k = 0; k < kCells; ++k) {
    const double q = learned.visits[k] == 0 ? mean
                     : sum > 0              ? static_cast<double>(learned.q[k])
                                            : 1;
    total += q + kLeast * mean;
    below[k] = total;
    means[k] = static_cast<float>(q);
    weights[k] = static_cast<float>(q + kLeast * mean);
  }
  for (float& weight : weights) weight *= static_cast<float>(kCells / total);
  frozen_[id.value].gain = gain_of_cells(shares, means, weights);
  for (size_t k = 0; k < kCells; ++k)
    frozen_[id.value].cdf[k] = k + 1 == kCells ? 1.0f : static_cast<float>(below[k] / total);
}

void DahmKellerGuide::end_pass() {
  for (uint32_t i : dirty_) {
    freeze(i);
    learned_[i].dirty = false;
  }
  dirty_.clear();
}

GuideStats DahmKellerGuide::stats() const {
  return {learned_.size(), 0,
          learned_index_.bytes() + frozen_index_.bytes() + learned_.capacity() * sizeof(Learned) +
              frozen_.capacity() * sizeof(Frozen) + dirty_.capacity() * sizeof(uint32_t),
          samples_seen_, refused_};
}

const DahmKellerGuide::Values* DahmKellerGuide::values(uint64_t key) const {
  const StateId id = learned_index_.find(key);
  return id.valid() ? &learned_[id.value].q : nullptr;
}

std::vector<TableSection> DahmKellerGuide::save() const {
  return save_cells(kDahmKellerLayout, grid_, samples_seen_, learned_index_.keys(),
                    [this](size_t i) {
                      return CellRecord{learned_[i].q, learned_[i].visits};
                    });
}

template <class Self, class Archive>
void DahmKellerGuide::exchange_state(Self& self, Archive& archive) {
  archive(self.samples_seen_, self.refused_, self.learned_index_, self.learned_, self.dirty_,
          self.frozen_index_, self.frozen_);
}

void DahmKellerGuide::save_state(SnapshotWriter& out) const { exchange_state(*this, out); }

void DahmKellerGuide::load_state(SnapshotReader& in) { exchange_state(*this, in); }

Status DahmKellerGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(learned_.empty());
  const auto add = [this](uint64_t key, const CellRecord& record) {
    Learned& state = learned_state(key);
    std::ranges::copy(record.values, state.q.begin());
    std::ranges::copy(record.counts, state.visits.begin());
    state.scattered = scattered_of(state.q);
  };
  const Result<uint64_t> samples_seen =
      load_cells(sections, kDahmKellerLayout, grid_, max_states_, max_bytes_, add);
  if (!samples_seen.ok()) return samples_seen.error();
  samples_seen_ = samples_seen.value();
  end_pass();
  return {};
}

Status DahmKellerGuide::merge(const GuideTable& other) {
  const auto* from = dynamic_cast<const DahmKellerGuide*>(&other);
  if (!from) return cannot_merge(*this, other);
  if (Status s = check_mergeable(grid_, from->grid_, learned_index_, from->learned_index_,
                                 max_states_, max_bytes_);
      !s.ok())
    return s;
  const auto& keys = from->learned_index_.keys();
  for (size_t i = 0; i < keys.size(); ++i) {
    Learned& state = learned_state(keys[i]);
    for (size_t k = 0; k < kCells; ++k)
      merge_cell(state.q[k], state.visits[k], from->learned_[i].q[k], from->learned_[i].visits[k]);
    state.scattered = scattered_of(state.q);
  }
  samples_seen_ += from->samples_seen_;
  end_pass();
  return {};
}

}  // namespace qray
