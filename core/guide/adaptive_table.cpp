// AdaptiveGuide's tables: two made one, and what stands in a file.
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/guide/adaptive.h"
#include "core/guide/tree_sections.h"

namespace qray {
namespace {

constexpr uint32_t kMaxLoadedDepth = 16;  // of directions
constexpr uint32_t kMaxCount = std::numeric_limits<uint32_t>::max();

bool fit_together(const DirectionTrees::Sums& a, const DirectionTrees::Sums& b) {
  return a.s <= DirectionTrees::kMaxSum - b.s && a.n <= kMaxCount - b.n;
}

}  // namespace

// Cuts wherever the other table did.
void AdaptiveGuide::refine_as(const AdaptiveGuide& other) {
  Growth growth = whole_trees();
  for (const State& o : other.states_) {
    const auto leaf_of = [&] { return tree_.leaf_with(o.key); };
    for (uint32_t leaf = leaf_of(); leaf != SpatialTree::kNone && states_[leaf].key != o.key;
         leaf = leaf_of()) {
      cut(leaf, growth.shares);
      for (const size_t half : {size_t{leaf}, states_.size() - 1})
        states_[half].key = tree_.key(static_cast<uint32_t>(half));
    }
  }
  rebuild(growth, kShareOne);
}

Status AdaptiveGuide::merge(const Guide& other) {
  const auto* table = dynamic_cast<const AdaptiveGuide*>(&other);
  if (!table) return Guide::merge(other);
  if (table->tree_.cube_exponent() != tree_.cube_exponent() ||
      !(table->tree_.origin() == tree_.origin()) || table->radiance_unit_ != radiance_unit_)
    return Error{ErrorCode::kConflict, "the tables' cubes or units differ", "table"};
  AdaptiveGuide from(*table), to(*this);
  from.refine_as(to);
  to.refine_as(from);
  DirectionTrees next;
  for (uint32_t leaf = 0; leaf < to.states_.size(); ++leaf) {
    const uint32_t same = from.tree_.leaf_with(to.states_[leaf].key);
    const auto sums = to.sums_[leaf].all(), add = from.sums_[same].all();
    bool fits = true;
    for (size_t i = 0; i < sums.size(); ++i) {
      fits = fits && *sums[i] <= DirectionTrees::kMaxSum - *add[i];
      if (fits) *sums[i] += *add[i];
    }
    Cells cells = to.directions_.take(to.states_[leaf].root);
    const Cells more = from.directions_.take(from.states_[same].root);
    if (!fits || !fit_together(DirectionTrees::total(cells), DirectionTrees::total(more)))
      return Error{ErrorCode::kTooLarge, "both tables have counted too much for one", "table"};
    DirectionTrees::add_cells(cells, more);
    DirectionTrees::estimate(cells, params_.direction.shrinkage);
    const uint64_t key = to.states_[leaf].key;
    to.states_[leaf] = {};  // as load() would
    to.states_[leaf].key = key;
    to.summarize(to.states_[leaf], to.sums_[leaf]);
    put(to.states_[leaf], std::move(cells), next);
  }
  to.directions_ = std::move(next);
  to.index();
  if (to.bytes() > max_bytes_) return over_memory("both tables need", max_bytes_, "table");
  tree_ = std::move(to.tree_);
  states_ = std::move(to.states_);
  sums_ = std::move(to.sums_);
  directions_ = std::move(to.directions_);
  samples_seen_ += table->samples_seen_;
  return {};
}

// Sections: ACUB (the cube, the unit, the samples seen), AQTD (a record per state: key, sums, then
// the direction cells with a leaf's sums).
std::vector<TableSection> AdaptiveGuide::save() const {
  ByteWriter cube, out;
  write_cube(cube, tree_);
  cube.f64(radiance_unit_);
  cube.u64(samples_seen_);
  std::vector<uint32_t> known = leaves_by_key(tree_);
  std::erase_if(known, [&](uint32_t leaf) { return sums_[leaf].n == 0; });
  out.u64(known.size());
  for (uint32_t s : known) {
    out.u64(states_[s].key);
    for (const auto* v : sums_[s].all()) out.i64(*v);
    write_cells(out, directions_.take(states_[s].root), [&](const Cell& c, const Cell* four) {
      if (four) return;
      out.i64(c.sums.s);
      out.u32(c.sums.n);
    });
  }
  return {{"ACUB", cube.take()}, {"AQTD", out.take()}};
}

Status AdaptiveGuide::load_state(ByteReader& in, uint32_t leaf) {
  Sums sums;
  bool good = true;
  for (auto* v : sums.all()) {
    *v = in.i64();
    good = good && *v >= 0 && *v <= DirectionTrees::kMaxSum;
  }
  good = good && sums.n > 0 && sums.n_upper <= sums.n;
  DirectionTrees::Sums total;
  Cells cells = read_cells(in, kMaxLoadedDepth, [&](Cell& c, const Cell* four) {
    if (four) return true;
    c.sums = {in.i64(), in.u32()};
    if (c.sums.s < 0 || !fit_together(c.sums, total)) return false;
    total = {total.s + c.sums.s, total.n + c.sums.n};
    return true;
  });
  if (!good || cells.empty())
    return Error{ErrorCode::kCorrupt, "expected sums of 0..2^60 and whole trees", ""};
  add_states();
  DirectionTrees::estimate(cells, params_.direction.shrinkage);
  states_[leaf].root = directions_.put(cells);
  summarize(states_[leaf], sums);
  sums_[leaf] = sums;
  return {};
}

Status AdaptiveGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(samples_seen_ == 0);
  double unit = 0;
  uint64_t samples_seen = 0;
  const Status cube = read_cube(sections, "ACUB", "AQTD", tree_, [&](ByteReader& in) {
    unit = in.f64();
    samples_seen = in.u64();
  });
  if (!cube.ok()) return cube;
  if (!(unit > 0) || !std::isfinite(unit))
    return Error{ErrorCode::kCorrupt, "expected a unit of radiance over 0", "table:ACUB"};
  radiance_unit_ = unit;  // it goes on with the table's, should lights have changed
  const Error too_large = over_memory("the table needs", max_bytes_, "table:AQTD");
  const auto record = [&](ByteReader& in, uint32_t leaf) -> Status {
    const Status status = load_state(in, leaf);
    const bool large = status.ok() && bytes() / 2 > max_bytes_;  // with what load leaves over
    return large ? too_large : status;
  };
  const Result<uint64_t> count =
      read_records(sections[1], "state", tree_, SpatialTree::kFaces, record);
  if (!count.ok()) return count.error();
  rebuild(whole_trees(), kShareOne);
  if (count.value() > 0 && bytes() > max_bytes_) return too_large;
  samples_seen_ = samples_seen;
  return {};
}

}  // namespace qray
