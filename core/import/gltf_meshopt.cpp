#include "core/import/gltf_meshopt.h"

#include <meshoptimizer.h>

#include <climits>

namespace qray {
namespace {

// No part of a view unpacks to more than this many times its packed bytes: of vertices 16 bytes
// take two bits at least, and a triangle of up to 12 bytes takes one.
constexpr size_t kMostGain = 64;

size_t size_of(const JsonNode& node, int most) {
  return static_cast<size_t>(node.integer(1, most));
}

}  // namespace

GltfPacked read_gltf_packed(const JsonNode& extension, int buffer_count) {
  if (buffer_count == 0) extension.fail("expected no such extension, there are no buffers");
  GltfPacked out{};
  out.buffer = extension.get("buffer").integer(0, buffer_count - 1);
  if (const auto offset = extension.find("byteOffset"))
    out.byte_offset = static_cast<size_t>(offset->integer(0, INT_MAX));
  out.byte_length = size_of(extension.get("byteLength"), INT_MAX);
  out.byte_stride = size_of(extension.get("byteStride"), 256);
  out.count = size_of(extension.get("count"), INT_MAX);
  if (out.size() / kMostGain > out.byte_length)
    extension.get("count").fail("more than " + std::to_string(out.byte_length) +
                                " packed bytes can hold");
  return out;
}

Bytes unpack_gltf(const JsonNode& extension, const GltfPacked& packed,
                  std::span<const uint8_t> bytes) {
  const JsonNode mode_node = extension.get("mode");
  const std::string& mode = mode_node.string();
  const auto filter_node = extension.find("filter");
  const std::string filter = filter_node ? filter_node->string() : "NONE";
  const size_t stride = packed.byte_stride, count = packed.count;
  const auto expect_stride = [&](bool fits, const char* what) {
    if (!fits) extension.get("byteStride").fail_expected(what);
  };
  Bytes out(packed.size());
  int result = -1;
  if (mode == "ATTRIBUTES") {
    expect_stride(stride % 4 == 0, "a multiple of 4");
    result = meshopt_decodeVertexBuffer(out.data(), count, stride, bytes.data(), bytes.size());
  } else if (mode == "TRIANGLES" || mode == "INDICES") {
    expect_stride(stride == 2 || stride == 4, "2 or 4");
    if (mode == "TRIANGLES" && count % 3 != 0)
      extension.get("count").fail_expected("a multiple of 3");
    if (filter != "NONE") filter_node->fail_expected("NONE for " + mode);
    result =
        mode == "TRIANGLES"
            ? meshopt_decodeIndexBuffer(out.data(), count, stride, bytes.data(), bytes.size())
            : meshopt_decodeIndexSequence(out.data(), count, stride, bytes.data(), bytes.size());
  } else {
    mode_node.fail_expected("ATTRIBUTES, TRIANGLES or INDICES");
  }
  if (result != 0) extension.fail("the packed bytes are damaged");
  if (filter == "OCTAHEDRAL") {
    expect_stride(stride == 4 || stride == 8, "4 or 8 with this filter");
    meshopt_decodeFilterOct(out.data(), count, stride);
  } else if (filter == "QUATERNION") {
    expect_stride(stride == 8, "8 with this filter");
    meshopt_decodeFilterQuat(out.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(out.data(), count, stride);
  } else if (filter != "NONE") {
    filter_node->fail_expected("NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  }
  return out;
}

}  // namespace qray
