// Mitsuba's .serialized meshes. An input without the format's magic is taken for what a file holds
// deflated, which a blind change of deflated bytes would hardly ever reach.
#include "core/import/import_failure.h"
#include "core/import/serialized.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/load.h"

namespace qray::fuzz {
namespace {

constexpr uint16_t kMagic = 0x041C;
constexpr size_t kStoredBlock = 0xffff;  // the most that one holds

// One deflated block, stored as it is: the reader asks for no more than that.
Bytes as_file(std::span<const uint8_t> content) {
  ByteWriter out;
  out.u16(kMagic);
  out.u16(4);
  out.u16(0x0178);  // zlib's header
  out.u8(1);        // the last block, stored
  const auto size = static_cast<uint16_t>(content.size());
  out.u16(size);
  out.u16(static_cast<uint16_t>(~size));
  out.bytes(content);
  return out.take();
}

void expect_mesh_or_error(std::span<const uint8_t> file, size_t shape_index) {
  try {
    const SerializedShape shape =
        read_serialized(file, shape_index, small_scenes().limits, "scene.serialized");
    expect_indices_in_range(shape.mesh);
  } catch (const ImportFailure& failure) {
    expect_said_why(failure.error);
  }
}

}  // namespace
}  // namespace qray::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace qray::fuzz;
  const std::span<const uint8_t> input(data, size);
  if (qray::ByteReader(input).u16() == kMagic) {
    for (size_t shape = 0; shape < 2; ++shape) expect_mesh_or_error(input, shape);
  } else if (size <= kStoredBlock) {
    expect_mesh_or_error(as_file(input), 0);
  }
  return 0;
}
