#include "core/guide/ppg_layout.h"

#include <cmath>

namespace qray {
namespace {

using Cell = DirectionTrees::Cell;

constexpr std::string_view kPpgCubeTag = "PCUB", kPpgRecordsTag = "PDTR";
constexpr double kMeanOne = DirectionTrees::kChances / 4;  // a chance that leaves the mean as it is
constexpr int64_t kMaxIterationSamples = int64_t{1} << 60;
constexpr uint32_t kMaxIterations = 64;

Status read_record(ByteReader& in, PpgRecord& record) {
  const uint8_t ready = in.u8();
  bool good = ready <= 1;
  record.ready = ready != 0;
  for (float* v : {&record.theta, &record.first_moment, &record.second_moment}) {
    *v = in.f32();
    good = good && std::isfinite(*v);
  }
  record.steps = in.u32();
  good = good && std::abs(record.theta) <= PpgRecord::kMaxTheta && record.second_moment >= 0;
  record.cells = read_cells(in, PpgRecord::kMaxDepth, [&](const Cell& c, Cell* four) {
    if (!four) return !c.joined;  // which this method does not know
    int sum = 0;
    for (int q = 0; q < 4; ++q) {
      const int chance = in.u8();
      if (chance == 0) return false;
      sum += chance;
      four[q].mean = c.mean * chance / kMeanOne;
    }
    return sum == DirectionTrees::kChances;
  });
  if (good && !record.cells.empty()) return {};
  return Error{ErrorCode::kCorrupt, "expected a finite chance and whole trees", ""};
}

}  // namespace

std::vector<TableSection> encode_ppg(const SpatialTree& tree, const PpgHead& head,
                                     const std::function<PpgRecord(uint32_t leaf)>& of) {
  ByteWriter cube, out;
  write_cube(cube, tree);
  cube.u64(head.samples_seen);
  cube.i64(head.last_iteration_samples);
  cube.u32(head.iteration);
  out.u64(tree.leaves());
  for (uint32_t leaf : leaves_by_key(tree)) {
    const PpgRecord record = of(leaf);
    out.u64(tree.key(leaf));
    out.u8(record.ready);
    for (float v : {record.theta, record.first_moment, record.second_moment}) out.f32(v);
    out.u32(record.steps);
    write_cells(out, record.cells, [&](const Cell& c, const Cell* four) {
      for (int q = 0; four && q < 4; ++q)
        out.u8(static_cast<uint8_t>(std::lround(four[q].mean / c.mean * kMeanOne)));
    });
  }
  return {{std::string(kPpgCubeTag), cube.take()}, {std::string(kPpgRecordsTag), out.take()}};
}

Result<PpgHead> decode_ppg_head(std::span<const TableSection> sections) {
  if (Status s = expect_sections(sections, kPpgCubeTag, kPpgRecordsTag); !s.ok()) return s.error();
  PpgHead head;
  ByteReader in(sections[0].bytes);
  head.cube = read_cube(in);
  head.samples_seen = in.u64();
  head.last_iteration_samples = in.i64();
  head.iteration = in.u32();
  if (!in.ok() || in.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size", place_of(kPpgCubeTag)};
  if (head.last_iteration_samples < 0 || head.last_iteration_samples > kMaxIterationSamples ||
      head.iteration > kMaxIterations)
    return Error{ErrorCode::kCorrupt, "wrong iterations", place_of(kPpgCubeTag)};
  return head;
}

Status decode_ppg_records(std::span<const TableSection> sections, SpatialTree& tree,
                          const std::function<Status(uint32_t leaf, PpgRecord&& record)>& add) {
  const Result<uint64_t> count =
      read_records(sections[1], "place", tree, 1, [&](ByteReader& in, uint32_t leaf) -> Status {
        PpgRecord record;
        if (Status s = read_record(in, record); !s.ok()) return s;
        return add(leaf, std::move(record));
      });
  if (!count.ok()) return count.error();
  if (count.value() != tree.leaves())
    return Error{ErrorCode::kCorrupt, "places are missing", place_of(kPpgRecordsTag)};
  return {};
}

std::string ppg_head_place() { return place_of(kPpgCubeTag); }

std::string ppg_records_place() { return place_of(kPpgRecordsTag); }

Result<GuideSetup> setup_of_ppg(std::span<const TableSection> sections) {
  const Result<PpgHead> head = decode_ppg_head(sections);
  if (!head.ok()) return head.error();
  return setup_of_cube(head.value().cube, place_of(kPpgCubeTag));
}

}  // namespace qray
