// AdaptiveGuide's tables: two made one, saved, loaded. Their bytes are adaptive_layout.h's.
#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/guide/adaptive.h"
#include "core/guide/adaptive_layout.h"

namespace qray {

// Cuts wherever the other table did.
void AdaptiveGuide::refine_as(const AdaptiveGuide& other) {
  Growth growth = whole_trees();
  for (const State& o : other.states_) {
    const auto leaf_of = [&] { return tree_.leaf_with(o.key); };
    for (uint32_t leaf = leaf_of(); leaf != SpatialTree::kNone && states_[leaf].key != o.key;
         leaf = leaf_of()) {
      cut(leaf, growth);
      for (const size_t half : {size_t{leaf}, states_.size() - 1})
        states_[half].key = tree_.key(static_cast<uint32_t>(half));
    }
  }
  rebuild(growth);
}

Status AdaptiveGuide::merge(const GuideTable& other) {
  const auto* table = dynamic_cast<const AdaptiveGuide*>(&other);
  if (!table) return cannot_merge(*this, other);
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
    to.known_[leaf] = to.sums_[leaf].n;
    to.states_[leaf] = {};  // as load() would
    to.states_[leaf].key = key;
    to.summarize(to.states_[leaf], to.sums_[leaf]);
    put(to.states_[leaf], std::move(cells), next);
  }
  to.choose_lobe_shares();
  to.directions_ = std::move(next);
  to.index();
  if (to.bytes() > max_bytes_) return over_memory("both tables need", max_bytes_, "table");
  tree_ = std::move(to.tree_);
  states_ = std::move(to.states_);
  sums_ = std::move(to.sums_);
  known_ = std::move(to.known_);
  directions_ = std::move(to.directions_);
  // Of the same lights, unless one table is of a program that knew none.
  if (!lights_.merge(table->lights_) && lights_.empty()) lights_ = table->lights_;
  samples_seen_ += table->samples_seen_;
  worth_ = std::min(worth_, table->worth_);  // not known, if one is not
  return {};
}

std::vector<TableSection> AdaptiveGuide::save() const {
  std::vector<uint32_t> known = leaves_by_key(tree_);
  std::erase_if(known, [&](uint32_t leaf) { return sums_[leaf].n == 0; });
  std::vector<TableSection> sections = encode_adaptive(
      tree_, {{}, radiance_unit_, samples_seen_, worth_}, known, [&](uint32_t leaf) {
        return AdaptiveRecord{sums_[leaf], directions_.take(states_[leaf].root)};
      });
  if (lights_.has_learned()) sections.push_back({std::string(kLightsTag), lights_.save()});
  return sections;
}

void AdaptiveGuide::load_record(uint32_t leaf, AdaptiveRecord&& record) {
  add_states();
  DirectionTrees::estimate(record.cells, params_.direction.shrinkage);
  states_[leaf].root = directions_.put(record.cells);
  static_cast<ArrivalSums&>(sums_[leaf]) = record.sums;
  summarize(states_[leaf], sums_[leaf]);
}

Status AdaptiveGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(samples_seen_ == 0);
  const Result<AdaptiveHead> head = decode_adaptive_head(sections);
  if (!head.ok()) return head.error();
  if (Status s = check_cube(head.value().cube, tree_, adaptive_head_place()); !s.ok()) return s;
  // It goes on with the table's unit, should lights have changed.
  radiance_unit_ = head.value().radiance_unit;
  const Error too_large = over_memory("the table needs", max_bytes_, adaptive_records_place());
  const auto add = [&](uint32_t leaf, AdaptiveRecord&& record) -> Status {
    load_record(leaf, std::move(record));
    if (bytes() / 2 > max_bytes_) return too_large;  // with what load leaves over
    return {};
  };
  const Result<uint64_t> count = decode_adaptive_records(sections, tree_, add);
  if (!count.ok()) return count.error();
  choose_lobe_shares();
  rebuild(whole_trees());
  if (count.value() > 0 && bytes() > max_bytes_) return too_large;
  if (Result<std::optional<LightImportance>> lights = decode_lights(sections); !lights.ok())
    return lights.error();
  else if (lights.value() && lights.value()->clusters() == lights_.clusters())
    lights_ = std::move(*lights.value());  // else they were others
  samples_seen_ = head.value().samples_seen;
  worth_ = head.value().worth;
  return {};
}

}  // namespace qray
