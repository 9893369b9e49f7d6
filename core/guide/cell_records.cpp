#include "core/guide/cell_records.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace qray {
namespace {

struct Record {
  uint64_t key = 0;
  std::vector<float> values;
  std::vector<uint32_t> counts;
};

// False: a value that no guide learns.
bool read_record(ByteReader& in, Record& record) {
  record.key = in.u64();
  bool good = record.key >> SurfaceGrid::kKeyBits == 0;
  for (size_t k = 0; k < record.values.size(); ++k) {
    record.values[k] = in.f32();
    record.counts[k] = in.u32();
    good = good && std::isfinite(record.values[k]) && record.values[k] >= 0;
  }
  return good;
}

Error no_room(uint64_t states, size_t max_states, size_t max_bytes, std::string where) {
  return {ErrorCode::kTooLarge,
          "the table's " + std::to_string(states) + " states do not fit into the " +
              std::to_string(max_bytes) + " bytes of memory that a table may take here, " +
              "enough for " + std::to_string(max_states),
          std::move(where)};
}

Result<uint64_t> read_grid(const TableSection& section, const SurfaceGrid& grid) {
  ByteReader in(section.bytes);
  const int64_t exponent = in.i64();
  Vec3 origin;
  for (int axis = 0; axis < 3; ++axis) origin[axis] = in.f32();
  const uint64_t samples_seen = in.u64();
  if (!in.ok() || in.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size", "table:" + section.tag};
  if (exponent != grid.cell_exponent() || !(origin == grid.origin_cells()))
    return Error{ErrorCode::kConflict,
                 "the table's grid (cells of 2^" + std::to_string(exponent) +
                     " m) is not this job's (2^" + std::to_string(grid.cell_exponent()) + " m)",
                 "table:" + section.tag};
  return samples_seen;
}

}  // namespace

std::vector<TableSection> save_cells(const CellFormat& format, const SurfaceGrid& grid,
                                     uint64_t samples_seen, std::span<const uint64_t> keys,
                                     const std::function<CellRecord(size_t)>& record) {
  std::vector<size_t> order(keys.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return keys[a] < keys[b]; });
  ByteWriter head;
  head.i64(grid.cell_exponent());
  for (int axis = 0; axis < 3; ++axis) head.f32(grid.origin_cells()[axis]);
  head.u64(samples_seen);
  ByteWriter states;
  states.u64(order.size());
  for (size_t i : order) {
    const CellRecord r = record(i);
    states.u64(keys[i]);
    for (size_t k = 0; k < format.cells; ++k) {
      states.f32(r.values[k]);
      states.u32(r.counts[k]);
    }
  }
  return {{std::string(format.grid_tag), head.take()},
          {std::string(format.states_tag), states.take()}};
}

Result<uint64_t> load_cells(std::span<const TableSection> sections, const CellFormat& format,
                            const SurfaceGrid& grid, size_t max_states, size_t max_bytes,
                            const std::function<void(uint64_t, const CellRecord&)>& add) {
  if (sections.size() != 2 || sections[0].tag != format.grid_tag ||
      sections[1].tag != format.states_tag)
    return Error{ErrorCode::kCorrupt,
                 "expected the sections " + std::string(format.grid_tag) + " and " +
                     std::string(format.states_tag),
                 "table"};
  const Result<uint64_t> samples_seen = read_grid(sections[0], grid);
  if (!samples_seen.ok()) return samples_seen;

  // 1. Sizes, before anything is allocated.
  const std::string where = "table:" + sections[1].tag;
  ByteReader in(sections[1].bytes);
  const uint64_t count = in.u64();
  const size_t record_bytes = 8 + format.cells * 8;
  if (!in.ok() || count != in.remaining() / record_bytes || in.remaining() % record_bytes != 0)
    return Error{ErrorCode::kCorrupt, "wrong size for " + std::to_string(count) + " states", where};
  if (count > max_states) return no_room(count, max_states, max_bytes, where);

  // 2. Order and values, before anything is taken.
  Record r{0, std::vector<float>(format.cells), std::vector<uint32_t>(format.cells)};
  ByteReader check = in;
  uint64_t last_key = 0;
  for (uint64_t i = 0; i < count; ++i) {
    if (!read_record(check, r) || (i > 0 && r.key <= last_key))
      return Error{ErrorCode::kCorrupt, "expected rising keys and finite values >= 0",
                   where + ", state " + std::to_string(i)};
    last_key = r.key;
  }
  for (uint64_t i = 0; i < count; ++i) {
    read_record(in, r);
    add(r.key, {r.values, r.counts});
  }
  return samples_seen;
}

Status check_mergeable(const SurfaceGrid& grid, const SurfaceGrid& other_grid,
                       const KeyIndex& states, const KeyIndex& other_states, size_t max_states,
                       size_t max_bytes) {
  if (!(grid == other_grid))
    return Error{ErrorCode::kConflict,
                 "the tables' grids differ: cells of 2^" + std::to_string(grid.cell_exponent()) +
                     " m and of 2^" + std::to_string(other_grid.cell_exponent()) + " m",
                 "table"};
  const auto is_new = [&](uint64_t key) { return !states.find(key).valid(); };
  const size_t both =
      states.size() + static_cast<size_t>(std::ranges::count_if(other_states.keys(), is_new));
  if (both > max_states) return no_room(both, max_states, max_bytes, "table");
  return {};
}

void merge_cell(float& value, uint32_t& count, float other_value, uint32_t other_count) {
  const uint64_t updates = uint64_t{count} + other_count;
  if (updates == 0) {
    value = std::max(value, other_value);
    return;
  }
  // A compiler may fuse one of the two products with the sum: always the same one.
  const auto [less, more] =
      std::minmax({std::pair(count, value), std::pair(other_count, other_value)});
  const double sum = static_cast<double>(less.first) * static_cast<double>(less.second) +
                     static_cast<double>(more.first) * static_cast<double>(more.second);
  value = static_cast<float>(sum / static_cast<double>(updates));
  count = static_cast<uint32_t>(std::min<uint64_t>(updates, ~0u));
}

std::vector<GuidePoint> points_of(const KeyIndex& states, size_t most) {
  std::vector<GuidePoint> points;
  for (size_t state = 0; state < states.size(); ++state) {
    const uint64_t key = states.keys()[state];
    points.push_back(
        {StateId(static_cast<uint32_t>(state)), key, Frame(SurfaceGrid::normal_of(key))});
  }
  return spread_over(std::move(points), most);
}

}  // namespace qray
