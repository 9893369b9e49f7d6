// The layout of `adaptive`'s tables, which proto/table_file.md describes: sections ACUB (the cube,
// the unit of radiance, the samples seen, the worth) and AQTD (a record per state: key, sums, then
// the direction cells with a leaf's sums); ALOB (of each record how lobes share directions with the
// guide) and ALIT (what was learned of lights), which may be left out. Encoding, decoding, and
// checks of each record. Pure functions.
#pragma once

#include "core/guide/arrival_sums.h"
#include "core/guide/guide_table.h"
#include "core/guide/light_importance.h"
#include "core/guide/tree_layout.h"

namespace qray {

struct AdaptiveHead {
  TableCube cube;
  double radiance_unit = 0;
  uint64_t samples_seen = 0;
  GuideWorth worth;
};
struct AdaptiveRecord {
  ArrivalSums sums;
  DirectionTrees::Cells cells;
};

// `leaves`: whose records are written, by rising key. The head's cube is the tree's.
std::vector<TableSection> encode_adaptive(const SpatialTree& tree, const AdaptiveHead& head,
                                          std::span<const uint32_t> leaves,
                                          const std::function<AdaptiveRecord(uint32_t leaf)>& of);
// kCorrupt.
Result<AdaptiveHead> decode_adaptive_head(std::span<const TableSection> sections);
// Cuts the records' leaves out of the tree and hands each record to `add`, whose errors get their
// place. Returns the number of records. kCorrupt.
Result<uint64_t> decode_adaptive_records(
    std::span<const TableSection> sections, SpatialTree& tree,
    const std::function<Status(uint32_t leaf, AdaptiveRecord&& record)>& add);
constexpr std::string_view kLightsTag = "ALIT";
// None: the table has no such section. kCorrupt.
Result<std::optional<LightImportance>> decode_lights(std::span<const TableSection> sections);
// Of errors about the cube, and about all records.
std::string adaptive_head_place();
std::string adaptive_records_place();

Result<GuideSetup> setup_of_adaptive(std::span<const TableSection> sections);

// Whether sums of a tree that is read or merged may be added: nothing overflows when it learns on.
bool fit_together(const DirectionTrees::Sums& a, const DirectionTrees::Sums& b);

}  // namespace qray
