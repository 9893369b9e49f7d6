// Tables of the methods whose states are a SurfaceGrid's: their layouts, which
// proto/table_file.md describes, encoded, decoded and checked; and how two of them become one. For
// each state there is a value and how often it was updated, for each of its cells of directions.
// Pure functions.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/guide/guide_point.h"
#include "core/guide/guide_setup.h"
#include "core/guide/key_index.h"
#include "core/guide/surface_grid.h"
#include "core/guide/table_file.h"

namespace qray {

struct GridLayout {
  std::string_view grid_tag, states_tag;
  size_t cells;                                                      // a state
  std::string states_place() const { return place_of(states_tag); }  // of errors about states
};
constexpr GridLayout kHuangLayout{"HGRD", "HQ26", 26}, kDahmKellerLayout{"DGRD", "DQ64", 64};

// Borrowed from the table.
struct CellRecord {
  std::span<const float> values;
  std::span<const uint32_t> counts;
};

// `record(i)`: that of the state keys[i].
std::vector<TableSection> save_cells(const GridLayout& layout, const SurfaceGrid& grid,
                                     uint64_t samples_seen, std::span<const uint64_t> keys,
                                     const std::function<CellRecord(size_t)>& record);

// Checks sections, grid, size, order and values before the first `add(key, record)`; returns the
// transitions learned from. kCorrupt; kConflict: another grid; kTooLarge: over `max_states`, which
// is what `max_bytes` have room for.
Result<uint64_t> load_cells(std::span<const TableSection> sections, const GridLayout& layout,
                            const SurfaceGrid& grid, size_t max_states, size_t max_bytes,
                            const std::function<void(uint64_t, const CellRecord&)>& add);

// kCorrupt: also if no scene has such a grid.
Result<GuideSetup> setup_of_grid(std::span<const TableSection> sections, const GridLayout& layout);

// Whether the states of both tables fit into one of `max_states`. kConflict: their grids differ.
Status check_mergeable(const SurfaceGrid& grid, const SurfaceGrid& other_grid,
                       const KeyIndex& states, const KeyIndex& other_states, size_t max_states,
                       size_t max_bytes);
// A cell becomes the mean of both over all updates, the same bits for (a, b) as for (b, a).
void merge_cell(float& value, uint32_t& count, float other_value, uint32_t other_count);

// Up to `most` of the states, spread over the order in which they came.
std::vector<GuidePoint> points_of(const KeyIndex& states, size_t most);

}  // namespace qray
