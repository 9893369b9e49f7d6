// Buffer views that EXT_meshopt_compression has packed, unpacked. Throws ImportFailure.
#pragma once

#include "core/import/gltf_model.h"

namespace qray {

constexpr const char* kGltfMeshopt = "EXT_meshopt_compression";

// What a view with the extension must know of it; `buffer` and its part hold the packed bytes.
struct GltfPacked {
  int buffer;
  size_t byte_offset, byte_length;
  size_t count, byte_stride;
  size_t size() const { return count * byte_stride; }
};

// `extension`: of a view. Checks ranges alone.
GltfPacked read_gltf_packed(const JsonNode& extension, int buffer_count);
Bytes unpack_gltf(const JsonNode& extension, const GltfPacked& packed,
                  std::span<const uint8_t> bytes);

}  // namespace qray
