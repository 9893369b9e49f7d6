// What the layouts of tables over a SpatialTree and DirectionTrees have alike: the cube, records by
// rising keys, trees of directions. The layouts themselves, with the bytes between these, are in
// adaptive_layout.h and ppg_layout.h; proto/table_file.md describes them. Pure functions.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/guide/direction_tree.h"
#include "core/guide/guide_setup.h"
#include "core/guide/spatial_tree.h"
#include "core/guide/table_file.h"

namespace qray {

// Of a table's first section.
struct TableCube {
  int64_t exponent = 0;  // the cube is 2^exponent metres wide
  Vec3 origin;           // metres
};
void write_cube(ByteWriter& out, const SpatialTree& tree);
TableCube read_cube(ByteReader& in);
// kConflict: the tree's cube is another.
Status check_cube(const TableCube& cube, const SpatialTree& tree, const std::string& where);
// Bounds that give the same cube. kCorrupt: no scene has such a cube.
Result<GuideSetup> setup_of_cube(const TableCube& cube, const std::string& where);

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
