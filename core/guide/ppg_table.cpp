// PpgGuide's tables, saved and loaded. Their bytes are ppg_layout.h's.
#include <cmath>

#include "core/base/check.h"
#include "core/guide/ppg.h"
#include "core/guide/ppg_layout.h"

namespace qray {

std::vector<TableSection> PpgGuide::save() const {
  const PpgHead head{{}, samples_seen_, last_iteration_samples_, static_cast<uint32_t>(iteration_)};
  return encode_ppg(tree_, head, [this](uint32_t i) {
    const Leaf& leaf = leaves_[i];
    return PpgRecord{leaf.ready,         leaf.theta, leaf.first_moment,
                     leaf.second_moment, leaf.steps, directions_.take(leaf.root)};
  });
}

void PpgGuide::load_record(uint32_t place, const PpgRecord& record) {
  leaves_.resize(tree_.leaves());
  Leaf leaf;
  leaf.ready = record.ready;
  leaf.theta = record.theta;
  leaf.first_moment = record.first_moment;
  leaf.second_moment = record.second_moment;
  leaf.steps = record.steps;
  leaf.fraction = 1 / (1 + std::exp(-leaf.theta));
  leaf.root = directions_.put(record.cells);
  leaves_[place] = leaf;
}

Status PpgGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(samples_seen_ == 0);
  const Result<PpgHead> head = decode_ppg_head(sections);
  if (!head.ok()) return head.error();
  if (Status s = check_cube(head.value().cube, tree_, ppg_head_place()); !s.ok()) return s;
  const Error too_large = over_memory("the table needs", max_bytes_, ppg_records_place());
  directions_.clear();
  const auto add = [&](uint32_t leaf, PpgRecord&& record) -> Status {
    load_record(leaf, record);
    if (bytes() / 2 > max_bytes_ && stats().states > 0) return too_large;
    return {};
  };
  if (Status s = decode_ppg_records(sections, tree_, add); !s.ok()) return s;
  index();
  if (stats().bytes > max_bytes_) return too_large;
  samples_seen_ = head.value().samples_seen;
  last_iteration_samples_ = head.value().last_iteration_samples;
  iteration_ = static_cast<int>(head.value().iteration);
  return {};
}

}  // namespace qray
