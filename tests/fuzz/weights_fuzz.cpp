// Files of a recovery network's weights.
#include <algorithm>

#include "core/recover/weights_file.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/fuzz.h"

namespace qray::fuzz {
namespace {

// Where proto/weights_file.md has them.
constexpr size_t kCrc = 16, kBody = 20, kId = kBody + 4, kIdSize = 32;

// The checksum, and an id of 32 bytes: the hash of the file as it is with none.
void repair(std::span<uint8_t> bytes) {
  if (bytes.size() < kId) return;
  if (bytes.size() >= kId + kIdSize && get_u32(bytes, kBody) == kIdSize) {
    ByteWriter body;
    body.u32(0);
    body.bytes(bytes.subspan(kId + kIdSize));
    ByteWriter file;
    file.bytes(bytes.first(kCrc));
    file.u32(crc32c(body.data()));
    file.bytes(body.data());
    const std::string id = sha256(file.data()).hex();
    std::copy_n(id.begin(), kIdSize, bytes.begin() + kId);
  }
  put_u32(bytes, kCrc, crc32c(bytes.subspan(kBody)));
}

void run(std::span<const uint8_t> bytes) {
  const Result<WeightsFile> weights = decode_weights(bytes);
  if (!weights.ok()) return expect_said_why(weights.error());
  QRAY_CHECK(std::ranges::equal(encode_weights(weights.value()), bytes));
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
