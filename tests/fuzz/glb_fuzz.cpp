// glTF's binary container. What changes an input's length mostly leaves its three lengths right.
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/load.h"

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  constexpr size_t kFileLength = 8, kJsonLength = 12, kChunk = 8, kJson = kJsonLength + kChunk;
  size = LLVMFuzzerMutate(data, size, max_size);
  const std::span<uint8_t> bytes(data, size);
  if (seed % qray::fuzz::kLeftBroken == 0 || size < kJson) return size;
  qray::fuzz::put_u32(bytes, kFileLength, static_cast<uint32_t>(size));
  const size_t json = qray::fuzz::get_u32(bytes, kJsonLength);
  if (json > size - kJson)
    qray::fuzz::put_u32(bytes, kJsonLength, static_cast<uint32_t>(size - kJson));
  else if (size - kJson - json >= kChunk)
    qray::fuzz::put_u32(bytes, kJson + json, static_cast<uint32_t>(size - kJson - json - kChunk));
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace qray::fuzz;
  static const Folder folder;
  expect_scene_or_error(folder.write("scene.glb", as_text({data, size})));
  return 0;
}
