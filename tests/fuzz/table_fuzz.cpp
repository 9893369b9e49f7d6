// Table files, and the guides that they give.
#include <algorithm>
#include <cmath>

#include "core/guide/open_table.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/fuzz.h"

namespace qray::fuzz {
namespace {

constexpr size_t kMaxGuideBytes = size_t{16} << 20;
constexpr size_t kPoints = 8;

// Where proto/table_file.md has them.
constexpr size_t kHeaderSize = 16, kHeaderCrc = 20, kHeader = 24;
constexpr size_t kSectionSize = 4, kSectionCrc = 12, kSection = 16;

// Sizes that reach beyond the end are cut, checksums made right.
void repair(std::span<uint8_t> bytes) {
  if (bytes.size() < kHeader) return;
  const size_t header = std::min<size_t>(get_u32(bytes, kHeaderSize), bytes.size() - kHeader);
  put_u32(bytes, kHeaderSize, static_cast<uint32_t>(header));
  put_u32(bytes, kHeaderCrc, crc32c(bytes.subspan(kHeader, header)));
  for (size_t at = kHeader + header + 4; at + kSection <= bytes.size();) {
    const size_t left = bytes.size() - at - kSection;
    const size_t size = std::min<size_t>(get_u32(bytes, at + kSectionSize), left);
    put_u32(bytes, at + kSectionSize, static_cast<uint32_t>(size));
    put_u32(bytes, at + kSectionSize + 4, 0);
    put_u32(bytes, at + kSectionCrc, crc32c(bytes.subspan(at + kSection, size)));
    at += kSection + size;
  }
}

void expect_density(const Guide& guide, const GuidePoint& point) {
  const float fraction = guide.mixture(point, {}).guide;
  QRAY_CHECK(fraction >= 0 && fraction <= 1);
  QRAY_CHECK(guide.gain(point) >= 0);
  guide.expectation(point);
  for (const Vec2 u : {Vec2{0, 0}, Vec2{0.3f, 0.7f}, Vec2{kOneMinusEpsilon, kOneMinusEpsilon}}) {
    const GuideSample sample = guide.sample(point, u);
    QRAY_CHECK(std::abs(length(sample.wi) - 1) < 1e-3f);
    QRAY_CHECK(sample.pdf_w >= 0 && std::isfinite(sample.pdf_w));
    const float pdf_w = guide.pdf_w(point, sample.wi);
    QRAY_CHECK(pdf_w >= 0 && std::isfinite(pdf_w));
  }
}

void run(std::span<const uint8_t> bytes) {
  const Result<TableFile> table = decode_table(bytes);
  if (!table.ok()) return expect_said_why(table.error());
  QRAY_CHECK(std::ranges::equal(encode_table(table.value()), bytes));
  const auto guide = open_table(table.value(), kMaxGuideBytes);
  if (!guide.ok()) return expect_said_why(guide.error());
  for (const GuidePoint& point : guide.value()->known_points(kPoints))
    expect_density(*guide.value(), point);

  // What it saves, it loads, and saves again alike.
  TableFile saved{table.value().header, guide.value()->save()};
  const auto again = open_table(saved, kMaxGuideBytes);
  QRAY_CHECK(again.ok());
  QRAY_CHECK(encode_table({saved.header, again.value()->save()}) == encode_table(saved));

  if (const Status merged = guide.value()->merge(*again.value()); !merged.ok())
    expect_said_why(merged.error());
  guide.value()->doubt();
  for (const GuidePoint& point : guide.value()->known_points(kPoints))
    expect_density(*guide.value(), point);
}

}  // namespace
}  // namespace qray::fuzz

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % qray::fuzz::kLeftBroken != 0) qray::fuzz::repair({data, size});
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  qray::fuzz::run({data, size});
  return 0;
}
