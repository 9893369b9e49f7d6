#include "core/guide/grid_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/guide/guide_inspector.h"

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

struct Head {
  int64_t exponent = 0;  // cells are 2^exponent metres wide
  Vec3 origin;           // in cells
  uint64_t samples_seen = 0;
};

Result<Head> read_head(std::span<const TableSection> sections, const GridLayout& layout) {
  if (Status s = expect_sections(sections, layout.grid_tag, layout.states_tag); !s.ok())
    return s.error();
  Head head;
  ByteReader in(sections[0].bytes);
  head.exponent = in.i64();
  for (int axis = 0; axis < 3; ++axis) head.origin[axis] = in.f32();
  head.samples_seen = in.u64();
  if (!in.ok() || in.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size", place_of(layout.grid_tag)};
  return head;
}

Status check_grid(const Head& head, const SurfaceGrid& grid, const GridLayout& layout) {
  if (head.exponent == grid.cell_exponent() && head.origin == grid.origin_cells()) return {};
  return Error{ErrorCode::kConflict,
               "the table's grid (cells of 2^" + std::to_string(head.exponent) +
                   " m) is not this job's (2^" + std::to_string(grid.cell_exponent()) + " m)",
               place_of(layout.grid_tag)};
}

}  // namespace

std::vector<TableSection> save_cells(const GridLayout& layout, const SurfaceGrid& grid,
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
    for (size_t k = 0; k < layout.cells; ++k) {
      states.f32(r.values[k]);
      states.u32(r.counts[k]);
    }
  }
  return {{std::string(layout.grid_tag), head.take()},
          {std::string(layout.states_tag), states.take()}};
}

Result<GuideSetup> setup_of_grid(std::span<const TableSection> sections, const GridLayout& layout) {
  const Result<Head> read = read_head(sections, layout);
  if (!read.ok()) return read.error();
  const Head& head = read.value();
  if (head.exponent < -kMaxTableExponent || head.exponent > kMaxTableExponent ||
      !is_finite(head.origin))
    return Error{ErrorCode::kCorrupt, "no scene has such a grid", place_of(layout.grid_tag)};
  const float side = std::ldexp(1.0f, static_cast<int>(head.exponent));
  GuideSetup setup;
  setup.bounds.lo = SurfaceGrid::inside_first_cell(head.origin, side);
  const float cells = static_cast<float>(setup.huang.grid);
  setup.bounds.hi = setup.bounds.lo + Vec3{side, side, side} * cells;
  return setup;
}

Result<uint64_t> load_cells(std::span<const TableSection> sections, const GridLayout& layout,
                            const SurfaceGrid& grid, size_t max_states, size_t max_bytes,
                            const std::function<void(uint64_t, const CellRecord&)>& add) {
  const Result<Head> head = read_head(sections, layout);
  if (!head.ok()) return head.error();
  if (Status s = check_grid(head.value(), grid, layout); !s.ok()) return s.error();

  // 1. Sizes, before anything is allocated.
  const std::string where = layout.states_place();
  ByteReader in(sections[1].bytes);
  const uint64_t count = in.u64();
  const size_t record_bytes = 8 + layout.cells * 8;
  if (!in.ok() || count != in.remaining() / record_bytes || in.remaining() % record_bytes != 0)
    return Error{ErrorCode::kCorrupt, "wrong size for " + std::to_string(count) + " states", where};
  if (count > max_states) return no_room(count, max_states, max_bytes, where);

  // 2. Order and values, before anything is taken.
  Record r{0, std::vector<float>(layout.cells), std::vector<uint32_t>(layout.cells)};
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
  return head.value().samples_seen;
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
