// The layout of `ppg`'s tables, which proto/table_file.md describes: sections PCUB (the cube, the
// samples seen, the iterations) and PDTR (a record per leaf: key, the state of its chance to be
// drawn from, then the direction cells with the chances of a cut one's quarters). What the current
// iteration has learned so far is left out. Encoding, decoding, and checks of each record. Pure
// functions.
#pragma once

#include "core/guide/tree_layout.h"

namespace qray {

struct PpgHead {
  TableCube cube;
  uint64_t samples_seen = 0;
  int64_t last_iteration_samples = 0;
  uint32_t iteration = 0;
};
struct PpgRecord {
  static constexpr int kMaxDepth = 12;  // of directions
  static constexpr float kMaxTheta = 20;

  bool ready = false;                                    // it was learned
  float theta = 0, first_moment = 0, second_moment = 0;  // Adam's state
  uint32_t steps = 0;
  DirectionTrees::Cells cells;  // their means are the density
};

// Of all leaves. The head's cube is the tree's.
std::vector<TableSection> encode_ppg(const SpatialTree& tree, const PpgHead& head,
                                     const std::function<PpgRecord(uint32_t leaf)>& of);
// kCorrupt.
Result<PpgHead> decode_ppg_head(std::span<const TableSection> sections);
// Cuts the records' leaves out of the tree and hands each record to `add`, whose errors get their
// place. kCorrupt: also if the records do not share out all of space.
Status decode_ppg_records(std::span<const TableSection> sections, SpatialTree& tree,
                          const std::function<Status(uint32_t leaf, PpgRecord&& record)>& add);
// Of errors about the cube, and about all records.
std::string ppg_head_place();
std::string ppg_records_place();

Result<GuideSetup> setup_of_ppg(std::span<const TableSection> sections);

}  // namespace qray
