#include "core/guide/light_importance.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/varint.h"
#include "core/guide/spatial_tree.h"

namespace qray {
namespace {

constexpr double kUnit = 0x1p30;        // of a sum of squares
constexpr double kMostSquare = 0x1p20;  // that one pick adds
constexpr uint32_t kFewest = 32;        // picks in a group, before it is believed
constexpr double kPrior = 4;            // picks that bring the group's mean, for each cluster
constexpr double kLeastRoot = 0.1;      // of a cluster's root, over that of the group's mean
constexpr float kReserved = 1;          // in a table, for each group
constexpr uint64_t kMostSum = uint64_t{1} << 58;  // what is more is halved between passes

}  // namespace

LightImportance::LightImportance(LightClusters clusters)
    : clusters_(std::move(clusters)), count_(clusters_.count()) {
  if (empty()) return;
  squares_.resize(kPlaces * count_);
  counts_.resize(kPlaces * count_);
  known_.resize(kPlaces);
  weights_.resize(kPlaces * count_);
}

size_t LightImportance::bytes_of(const LightClusters& clusters) {
  if (clusters.groups.empty()) return 0;
  return kPlaces * (1 + clusters.count() * (sizeof(uint64_t) + sizeof(uint32_t) + sizeof(float)));
}

uint32_t LightImportance::place(Vec3 p, Vec3 n) const {
  const Vec3 extent = clusters_.bounds.extent();
  uint32_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float t = (p[axis] - clusters_.bounds.lo[axis]) / extent[axis] * kCells;
    const int along = t > 0 ? static_cast<int>(std::min(t, kCells - 1.0f)) : 0;  // NaN too
    cell = cell * kCells + static_cast<uint32_t>(along);
  }
  return cell * kFaces + static_cast<uint32_t>(SpatialTree::face_of(n));
}

void LightImportance::record(uint32_t place, std::span<const ClusterPick> picks,
                             float estimate) const {
  for (const ClusterPick& pick : picks) {
    const double over = double{estimate} * double{pick.scale}, square = over * over;
    if (!std::isfinite(square)) continue;
    const size_t i = place * count_ + pick.cluster;
    std::atomic_ref(counts_[i]).fetch_add(1, std::memory_order_relaxed);
    if (square > 0)
      std::atomic_ref(squares_[i])
          .fetch_add(static_cast<uint64_t>(std::min(square, kMostSquare) * kUnit),
                     std::memory_order_relaxed);
  }
}

void LightImportance::end_pass() {
  for (uint32_t place = 0; place < (empty() ? 0 : kPlaces); ++place) solve(place);
}

void LightImportance::solve(uint32_t place) {
  const size_t row = place * count_;
  const std::span counts(&counts_[row], count_);
  known_[place] = 0;
  if (std::ranges::none_of(counts, [](uint32_t count) { return count > 0; })) return;
  bool any = false;
  size_t first = row;
  for (const LightClusters::Group& group : clusters_.groups) {
    double sum = 0, picks = 0;
    for (size_t i = first; i < first + group.count; ++i) {
      if (squares_[i] > kMostSum) squares_[i] /= 2, counts_[i] /= 2;
      sum += static_cast<double>(squares_[i]), picks += counts_[i];
    }
    const bool learned = picks >= kFewest && sum > 0;
    const double mean = learned ? sum / picks : 1;
    const auto root = [&](size_t i) {
      if (!learned) return 1.0;
      const double square =
          (static_cast<double>(squares_[i]) + kPrior * mean) / (counts_[i] + kPrior);
      return std::max(std::sqrt(square / mean), kLeastRoot);
    };
    any |= learned;
    if (group.priors.empty()) {
      for (size_t i = first; i < first + group.count; ++i)
        weights_[i] = static_cast<float>(root(i));
    } else {
      double below = 0, all = 0;
      for (size_t i = 0; i < group.count; ++i) all += double{group.priors[i]} * root(first + i);
      for (size_t i = 0; i < group.count; ++i) {
        below += double{group.priors[i]} * root(first + i);
        weights_[first + i] = static_cast<float>(below / all);
      }
      // Behind the last that can be picked there is nothing.
      for (size_t i = group.count;
           i-- > 0 && weights_[first + i] >= weights_[first + group.count - 1];)
        weights_[first + i] = 1;
    }
    first += group.count;
  }
  known_[place] = any;
}

void LightImportance::fade(int times) {
  for (uint64_t& square : squares_) square /= static_cast<uint64_t>(times);
  for (uint32_t& count : counts_) count /= static_cast<uint32_t>(times);
  end_pass();
}

bool LightImportance::merge(const LightImportance& other) {
  if (!(clusters_ == other.clusters_)) return false;
  for (size_t i = 0; i < squares_.size(); ++i) {
    squares_[i] += other.squares_[i];
    counts_[i] += other.counts_[i];
  }
  end_pass();
  return true;
}

bool LightImportance::fits() const {
  const size_t places = empty() ? 0 : kPlaces, all = places * count_;
  return known_.size() == places && weights_.size() == all && squares_.size() == all &&
         counts_.size() == all;
}

void LightImportance::save_copy(SnapshotWriter& out) const {
  std::vector<float> rows;
  for (size_t place = 0; place < known_.size(); ++place)
    if (known_[place])
      rows.insert(rows.end(), weights_.begin() + static_cast<ptrdiff_t>(place * count_),
                  weights_.begin() + static_cast<ptrdiff_t>((place + 1) * count_));
  out(known_, rows);
}

void LightImportance::load_copy(SnapshotReader& in) {
  std::vector<uint8_t> known;
  std::vector<float> rows;
  in(known, rows);
  const auto number = static_cast<size_t>(
      std::ranges::count_if(known, [](uint8_t is_known) { return is_known != 0; }));
  if (known.size() != known_.size() || rows.size() != number * count_) return in.fail();
  known_ = std::move(known);
  auto row = rows.begin();
  for (size_t place = 0; place < known_.size(); ++place)
    if (known_[place]) {
      std::copy_n(row, count_, weights_.begin() + static_cast<ptrdiff_t>(place * count_));
      row += static_cast<ptrdiff_t>(count_);
    }
  forget();
}

void LightImportance::forget() {
  std::ranges::fill(squares_, 0);
  std::ranges::fill(counts_, 0);
}

// Of each cluster that was picked, place by place: its distance from the one before, from 1 on, how
// often, and the sum; then a 0.
void LightImportance::write_learned(ByteWriter& out) const {
  size_t next = 0;
  for (size_t i = 0; i < counts_.size(); ++i) {
    if (counts_[i] == 0) continue;
    put_varint(out, i + 1 - next);
    put_varint(out, counts_[i]);
    put_varint(out, squares_[i]);
    next = i + 1;
  }
  put_varint(out, 0);
}

void LightImportance::take_learned(ByteWriter& out) {
  write_learned(out);
  forget();
}

bool LightImportance::read_learned(ByteReader& in, Learned& learned) const {
  uint64_t next = 0;
  for (;;) {
    uint64_t step = 0, count = 0, square = 0;
    if (!get_varint(in, step) || step > counts_.size() - next) return false;
    if (step == 0) return true;
    if (!get_varint(in, count) || !get_varint(in, square) || count > ~uint32_t{0}) return false;
    next += step;
    learned.sums.push_back({next - 1, square, static_cast<uint32_t>(count)});
  }
}

void LightImportance::add(const Learned& learned) {
  for (const auto& [i, square, count] : learned.sums) squares_[i] += square, counts_[i] += count;
}

bool LightImportance::has_learned() const {
  return std::ranges::any_of(counts_, [](uint32_t count) { return count > 0; });
}

Bytes LightImportance::save() const {
  ByteWriter out;
  for (const Vec3 corner : {clusters_.bounds.lo, clusters_.bounds.hi})
    for (int axis = 0; axis < 3; ++axis) out.f32(corner[axis]);
  out.u64(clusters_.fingerprint);
  out.u32(static_cast<uint32_t>(clusters_.groups.size()));
  for (const LightClusters::Group& group : clusters_.groups) {
    out.u32(group.count);
    out.f32(kReserved);
    out.u8(group.priors.empty() ? 0 : 1);
    for (const float prior : group.priors) out.f32(prior);
  }
  write_learned(out);
  return out.take();
}

Result<LightImportance> LightImportance::load(std::span<const uint8_t> bytes) {
  const Error corrupt{ErrorCode::kCorrupt, "not what was learned of lights", ""};
  ByteReader in(bytes);
  LightClusters clusters;
  for (Vec3* corner : {&clusters.bounds.lo, &clusters.bounds.hi})
    for (int axis = 0; axis < 3; ++axis) (*corner)[axis] = in.f32();
  clusters.fingerprint = in.u64();
  const uint32_t groups = in.u32();
  if (groups == 0 || groups > LightClusters::kMostGroups) return corrupt;
  for (uint32_t g = 0; g < groups; ++g) {
    LightClusters::Group& group = clusters.groups.emplace_back();
    group.count = in.u32();
    (void)in.f32();  // kReserved
    if (!in.ok() || group.count == 0 || clusters.count() > LightClusters::kMost) return corrupt;
    double sum = 0;
    if (in.u8() != 0)
      for (uint32_t i = 0; i < group.count; ++i) {
        group.priors.push_back(in.f32());
        if (!(group.priors.back() >= 0)) return corrupt;  // NaN too
        sum += double{group.priors.back()};
      }
    if (!group.priors.empty() && !(std::abs(sum - 1) < 1e-3)) return corrupt;
  }
  if (!in.ok()) return corrupt;
  LightImportance importance(std::move(clusters));
  Learned learned;
  if (!importance.read_learned(in, learned) || in.remaining() > 0) return corrupt;
  importance.add(learned);
  importance.end_pass();
  return importance;
}

}  // namespace qray
