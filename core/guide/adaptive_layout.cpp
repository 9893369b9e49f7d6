#include "core/guide/adaptive_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qray {
namespace {

using Cell = DirectionTrees::Cell;

constexpr std::string_view kCubeTag = "ACUB", kRecordsTag = "AQTD", kLobesTag = "ALOB";
constexpr uint32_t kMaxDepth = 16;  // of directions
constexpr uint32_t kMaxCount = std::numeric_limits<uint32_t>::max();

const TableSection* find_section(std::span<const TableSection> sections, std::string_view tag) {
  const auto found = std::ranges::find(sections, tag, &TableSection::tag);
  return found == sections.end() ? nullptr : &*found;
}

Status read_record(ByteReader& in, ByteReader* lobes, AdaptiveRecord& record) {
  bool good = true;
  const auto sums = record.sums.all();
  for (size_t i = 0; i < (lobes ? sums.size() : ArrivalSums::kArrival); ++i) {
    *sums[i] = (i < ArrivalSums::kArrival ? in : *lobes).i64();
    good = good && *sums[i] >= 0 && *sums[i] <= DirectionTrees::kMaxSum;
  }
  good = good && record.sums.n > 0 && record.sums.n_upper <= record.sums.n;
  DirectionTrees::Sums total;
  record.cells = read_cells(in, kMaxDepth, [&](Cell& c, const Cell* four) {
    if (four) return true;
    c.sums = {in.i64(), in.u32()};
    if (c.sums.s < 0 || !fit_together(c.sums, total)) return false;
    total = {total.s + c.sums.s, total.n + c.sums.n};
    return true;
  });
  if (good && !record.cells.empty()) return {};
  return Error{ErrorCode::kCorrupt, "expected sums of 0..2^60 and whole trees", ""};
}

}  // namespace

bool fit_together(const DirectionTrees::Sums& a, const DirectionTrees::Sums& b) {
  return a.s <= DirectionTrees::kMaxSum - b.s && a.n <= kMaxCount - b.n;
}

std::vector<TableSection> encode_adaptive(const SpatialTree& tree, const AdaptiveHead& head,
                                          std::span<const uint32_t> leaves,
                                          const std::function<AdaptiveRecord(uint32_t leaf)>& of) {
  ByteWriter cube, out, lobes;
  write_cube(cube, tree);
  cube.f64(head.radiance_unit);
  cube.u64(head.samples_seen);
  cube.f64(head.worth.efficiency_gain);
  cube.f32(static_cast<float>(head.worth.unguided_cost));
  out.u64(leaves.size());
  for (uint32_t leaf : leaves) {
    const AdaptiveRecord record = of(leaf);
    out.u64(tree.key(leaf));
    const auto sums = record.sums.all();
    for (size_t i = 0; i < sums.size(); ++i)
      (i < ArrivalSums::kArrival ? out : lobes).i64(*sums[i]);
    write_cells(out, record.cells, [&](const Cell& c, const Cell* four) {
      if (four) return;
      out.i64(c.sums.s);
      out.u32(c.sums.n);
    });
  }
  return {{std::string(kCubeTag), cube.take()},
          {std::string(kRecordsTag), out.take()},
          {std::string(kLobesTag), lobes.take()}};
}

Result<AdaptiveHead> decode_adaptive_head(std::span<const TableSection> sections) {
  std::span<const TableSection> needed = sections;
  for (const std::string_view may_be_left_out : {kLightsTag, kLobesTag})
    if (needed.size() > 2 && needed.back().tag == may_be_left_out)
      needed = needed.first(needed.size() - 1);
  if (Status s = expect_sections(needed, kCubeTag, kRecordsTag); !s.ok()) return s.error();
  AdaptiveHead head;
  ByteReader in(sections[0].bytes);
  head.cube = read_cube(in);
  head.radiance_unit = in.f64();
  head.samples_seen = in.u64();
  // Version 2 has no worth; those before 11 had the rays of a path, which another view has not.
  if (in.remaining() > 0) head.worth.efficiency_gain = in.f64();
  if (in.remaining() == sizeof(double)) (void)in.f64();
  if (in.remaining() > 0) head.worth.unguided_cost = in.f32();
  if (!in.ok() || in.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size", place_of(kCubeTag)};
  if (!(head.radiance_unit > 0) || !std::isfinite(head.radiance_unit))
    return Error{ErrorCode::kCorrupt, "expected a unit of radiance over 0", place_of(kCubeTag)};
  for (const double v : {head.worth.efficiency_gain, head.worth.unguided_cost})
    if (!(v >= 0 && v <= GuideWorth::kMost))
      return Error{ErrorCode::kCorrupt, "expected a worth of 0 to 1e6", place_of(kCubeTag)};
  return head;
}

Result<uint64_t> decode_adaptive_records(
    std::span<const TableSection> sections, SpatialTree& tree,
    const std::function<Status(uint32_t leaf, AdaptiveRecord&& record)>& add) {
  const TableSection* of_lobes = find_section(sections, kLobesTag);
  ByteReader lobes(of_lobes ? std::span<const uint8_t>(of_lobes->bytes)
                            : std::span<const uint8_t>());
  const Result<uint64_t> count =
      read_records(sections[1], "state", tree, SpatialTree::kFaces,
                   [&](ByteReader& in, uint32_t leaf) -> Status {
                     AdaptiveRecord record;
                     if (Status s = read_record(in, of_lobes ? &lobes : nullptr, record); !s.ok())
                       return s;
                     return add(leaf, std::move(record));
                   });
  if (count.ok() && (!lobes.ok() || lobes.remaining() > 0))
    return Error{ErrorCode::kCorrupt, "wrong size", place_of(kLobesTag)};
  return count;
}

Result<std::optional<LightImportance>> decode_lights(std::span<const TableSection> sections) {
  const TableSection* section = find_section(sections, kLightsTag);
  if (!section) return std::optional<LightImportance>();
  Result<LightImportance> lights = LightImportance::load(section->bytes);
  if (!lights.ok()) return Error{ErrorCode::kCorrupt, lights.error().message, place_of(kLightsTag)};
  return std::optional(std::move(lights).value());
}

std::string adaptive_head_place() { return place_of(kCubeTag); }

std::string adaptive_records_place() { return place_of(kRecordsTag); }

Result<GuideSetup> setup_of_adaptive(std::span<const TableSection> sections) {
  const Result<AdaptiveHead> head = decode_adaptive_head(sections);
  if (!head.ok()) return head.error();
  Result<GuideSetup> setup = setup_of_cube(head.value().cube, place_of(kCubeTag));
  if (!setup.ok()) return setup;
  setup.value().brightest_light = static_cast<float>(head.value().radiance_unit);
  const Result<std::optional<LightImportance>> lights = decode_lights(sections);
  if (!lights.ok()) return lights.error();
  if (lights.value()) setup.value().lights = lights.value()->clusters();
  return setup;
}

}  // namespace qray
