// Tables without their scene: opened, checked and merged, for the command and the server. A table
// says of itself all that its guide needs: the method, and the grid or cube. Pure functions.
#pragma once

#include "core/guide/guide.h"
#include "core/guide/table_file.h"

namespace qray {

constexpr size_t kAnyTableBytes = size_t{1} << 60;  // for a look at a table of any size

// A guide that holds the table. Everything that load() checks is checked.
Result<std::unique_ptr<Guide>> open_table(const TableFile& table, size_t max_bytes);

// The integral of the guide's density over the point's domain, by directions of which half are the
// guide's own and half uniform over the sphere: 1, within .005 for the densities of tables' cells.
// A sampler that does not follow its density shows, too, and one that leaves the domain.
double density_integral(const GuideSampler& guide, const GuidePoint& point);

struct TableCheck {
  std::unique_ptr<Guide> guide;
  size_t densities = 0;  // states whose density was integrated
  double worst = 0;      // the farthest of them from 1
};
// More than load() checks: that the id is the file's, that its header and the table agree on the
// samples seen, and that sampled densities integrate to 1. kCorrupt names the place.
Result<TableCheck> check_table(const TableFile& table);

struct MergedTable {
  TableFile file;  // its parents are what it was merged of
  size_t states = 0;
};
// What all tables learned, in one: each has an id of its own, the first's method, scene and grid
// (else kConflict, naming what differs). The order of `tables` changes no bit. At most `max_bytes`
// of memory for each, and for the sum. Errors' places are "table <id>".
Result<MergedTable> merge_tables(std::span<const TableFile> tables, size_t max_bytes);

}  // namespace qray
