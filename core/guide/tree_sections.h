// What the guides whose states are a SpatialTree's and DirectionTrees' have alike in a table file:
// the cube, records by rising keys, trees of directions. proto/table_file.md has the bytes (`ACUB`
// with `AQTD`, `PCUB` with `PDTR`); what stands in them beside is the method's. Pure functions.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/guide/direction_tree.h"
#include "core/guide/spatial_tree.h"
#include "core/guide/table_file.h"

namespace qray {

void write_cube(ByteWriter& out, const SpatialTree& tree);
// Checks that the sections are these two, that the first has the tree's cube, and that nothing is
// left of it behind what `rest` reads. kCorrupt; kConflict: another cube.
Status read_cube(std::span<const TableSection> sections, std::string_view cube_tag,
                 std::string_view records_tag, const SpatialTree& tree,
                 const std::function<void(ByteReader&)>& rest);

// kTooLarge. `what`: "the table needs".
Error over_memory(const std::string& what, size_t max_bytes, const std::string& where);

std::vector<uint32_t> leaves_by_key(const SpatialTree& tree);
// A number of records, each a key, with which the leaf is cut out, and what `record` reads; nothing
// behind them. Returns the number. kCorrupt; errors of `record` get their place, with the `name` of
// a record.
Result<uint64_t> read_records(const TableSection& section, const std::string& name,
                              SpatialTree& tree, int trees,
                              const std::function<Status(ByteReader&, uint32_t leaf)>& record);

// Depth first, for each cell a byte, then what `rest` does with it. `four`: the cell's quarters; or
// null.
void write_cells(
    ByteWriter& out, const DirectionTrees::Cells& cells,
    const std::function<void(const DirectionTrees::Cell&, const DirectionTrees::Cell* four)>& rest);
// Empty: not a whole tree, one deeper than `max_depth`, or `rest` gave false.
DirectionTrees::Cells read_cells(
    ByteReader& in, uint32_t max_depth,
    const std::function<bool(DirectionTrees::Cell&, DirectionTrees::Cell* four)>& rest);

}  // namespace qray
