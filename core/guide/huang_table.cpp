// HuangGuide's tables, saved, loaded and merged. Their bytes are grid_table.h's.
#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/guide/grid_table.h"
#include "core/guide/huang.h"

namespace qray {

static_assert(kHuangLayout.cells == kDirections26);

std::vector<TableSection> HuangGuide::save() const {
  return save_cells(kHuangLayout, grid_, samples_seen_, learned_index_.keys(), [this](size_t i) {
    return CellRecord{learned_[i].q, learned_[i].count};
  });
}

Status HuangGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(learned_.empty());
  const auto add = [this](uint64_t key, const CellRecord& record) {
    const StateId id = learned_state(key);
    std::ranges::copy(record.values, learned_[id.value].q.begin());
    std::ranges::copy(record.counts, learned_[id.value].count.begin());
    mark(id);
  };
  const Result<uint64_t> samples_seen =
      load_cells(sections, kHuangLayout, grid_, max_states_, max_bytes_, add);
  if (!samples_seen.ok()) return samples_seen.error();
  samples_seen_ = samples_seen.value();
  end_pass();
  return check_densities();
}

Status HuangGuide::merge(const GuideTable& other) {
  const auto* from = dynamic_cast<const HuangGuide*>(&other);
  if (!from) return cannot_merge(*this, other);
  if (Status s = check_mergeable(grid_, from->grid_, learned_index_, from->learned_index_,
                                 max_states_, max_bytes_);
      !s.ok())
    return s;
  const auto& keys = from->learned_index_.keys();
  for (size_t i = 0; i < keys.size(); ++i) {
    const StateId id = learned_state(keys[i]);
    Learned& state = learned_[id.value];
    for (size_t a = 0; a < kDirections26; ++a)
      merge_cell(state.q[a], state.count[a], from->learned_[i].q[a], from->learned_[i].count[a]);
    mark(id);
  }
  samples_seen_ += from->samples_seen_;
  end_pass();
  return {};
}

// A loaded table must sample densities that integrate to one.
Status HuangGuide::check_densities() {
  for (size_t i = 0; i < frozen_.size(); ++i) {
    const uint64_t key = frozen_index_.keys()[i];
    const Values& shares = shares_of(key);
    double sum = 0;
    for (size_t a = 0; a < kDirections26; ++a)
      sum += static_cast<double>(shares[a]) * static_cast<double>(frozen_[i].weight[a]);
    if (!(std::abs(sum - 1) < 1e-3)) {
      return Error{ErrorCode::kCorrupt,
                   "the density integrates to " + std::to_string(sum) + ", expected 1",
                   kHuangLayout.states_place() + ", state " + std::to_string(i)};
    }
  }
  return {};
}

}  // namespace qray
