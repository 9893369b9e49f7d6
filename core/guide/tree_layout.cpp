#include "core/guide/tree_layout.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace qray {
namespace {

constexpr size_t kMaxCells = 1 << 17;  // of a tree
enum : uint8_t { kLeaf, kCut, kJoined };

}  // namespace

void write_cube(ByteWriter& out, const SpatialTree& tree) {
  out.i64(tree.cube_exponent());
  for (int axis = 0; axis < 3; ++axis) out.f32(tree.origin()[axis]);
}

TableCube read_cube(ByteReader& in) {
  TableCube cube;
  cube.exponent = in.i64();
  for (int axis = 0; axis < 3; ++axis) cube.origin[axis] = in.f32();
  return cube;
}

Status check_cube(const TableCube& cube, const SpatialTree& tree, const std::string& where) {
  if (cube.exponent == tree.cube_exponent() && cube.origin == tree.origin()) return {};
  return Error{ErrorCode::kConflict, "the table's cube is not this scene's", where};
}

Result<GuideSetup> setup_of_cube(const TableCube& cube, const std::string& where) {
  if (cube.exponent < -kMaxTableExponent || cube.exponent > kMaxTableExponent ||
      !is_finite(cube.origin))
    return Error{ErrorCode::kCorrupt, "no scene has such a cube", where};
  const float side = std::ldexp(1.0f, static_cast<int>(cube.exponent));
  GuideSetup setup;
  // Well within the cube, so that rounding takes nothing out of it.
  setup.bounds.lo = cube.origin + Vec3{side, side, side} * 0.0625f;
  setup.bounds.hi = cube.origin + Vec3{side, side, side} * 0.9375f;
  return setup;
}

std::vector<uint32_t> leaves_by_key(const SpatialTree& tree) {
  std::vector<uint32_t> leaves(tree.leaves());
  std::iota(leaves.begin(), leaves.end(), 0u);
  std::ranges::sort(leaves, {}, [&](uint32_t leaf) { return tree.key(leaf); });
  return leaves;
}

Result<uint64_t> read_records(const TableSection& section, const std::string& name,
                              SpatialTree& tree, int trees,
                              const std::function<Status(ByteReader&, uint32_t)>& record) {
  const std::string where = "table:" + section.tag;
  const auto corrupt = [](std::string what) { return Error{ErrorCode::kCorrupt, what, ""}; };
  ByteReader in(section.bytes);
  const uint64_t count = in.u64();
  std::vector<std::pair<uint64_t, uint32_t>> read;  // keys and their leaves
  const auto read_one = [&]() -> Status {
    const uint64_t key = in.u64();
    if (!SpatialTree::valid_key(key, trees)) return corrupt("not a key of a place");
    if (!read.empty() && key <= read.back().first) return corrupt("expected rising keys");
    const uint32_t leaf = tree.reach(key);
    if (leaf == SpatialTree::kNone) return corrupt("places hold one another");
    read.emplace_back(key, leaf);
    return record(in, leaf);
  };
  for (uint64_t i = 0; i < count; ++i)
    if (const Status status = read_one(); !status.ok())
      return Error{status.error().code, status.error().message,
                   where + ", " + name + " " + std::to_string(i)};
  if (!in.ok() || in.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size for " + std::to_string(count) + " " + name + "s",
                 where};
  for (const auto& [key, leaf] : read)  // cut after it was read?
    if (tree.key(leaf) != key) return Error{ErrorCode::kCorrupt, "places hold one another", where};
  return count;
}

void write_cells(
    ByteWriter& out, const DirectionTrees::Cells& cells,
    const std::function<void(const DirectionTrees::Cell&, const DirectionTrees::Cell*)>& rest) {
  std::vector<uint32_t> open{0};
  while (!open.empty()) {
    const DirectionTrees::Cell& c = cells[open.back()];
    open.pop_back();
    out.u8(c.child != 0 ? kCut : c.joined ? kJoined : kLeaf);
    rest(c, c.child != 0 ? &cells[c.child] : nullptr);
    for (uint32_t q = 4; c.child != 0 && q-- > 0;) open.push_back(c.child + q);
  }
}

DirectionTrees::Cells read_cells(
    ByteReader& in, uint32_t max_depth,
    const std::function<bool(DirectionTrees::Cell&, DirectionTrees::Cell*)>& rest) {
  DirectionTrees::Cells cells = DirectionTrees::one_cell();
  std::vector<uint32_t> open{0};
  while (!open.empty()) {
    const uint32_t c = open.back(), child = static_cast<uint32_t>(cells.size());
    open.pop_back();
    const uint8_t mark = in.u8();
    const bool cut = mark == kCut;
    if (mark > kJoined || (cut ? cells[c].depth >= max_depth || child > kMaxCells : c == 0))
      return {};
    if (cut) {
      cells[c].child = child;
      DirectionTrees::Cell quarter;
      quarter.depth = cells[c].depth + 1;
      cells.resize(child + 4, quarter);
      for (uint32_t q = 4; q-- > 0;) open.push_back(child + q);
    }
    cells[c].joined = mark == kJoined;
    if (!rest(cells[c], cut ? &cells[child] : nullptr) || !in.ok()) return {};
  }
  return cells;
}

}  // namespace qray
