#include "core/recover/weights_file.h"

#include <algorithm>
#include <cmath>

#include "core/recover/pyramid.h"

namespace qray {
namespace {

constexpr uint64_t kMagic = 0x3156435259415251;  // "QRAYRCV1"
constexpr size_t kMaxString = 256, kMaxHeldOut = 4096, kIdHexDigits = 32;
constexpr float kMaxValue = 1e4f;

Error corrupt(const ByteReader& in, const std::string& what) {
  return {ErrorCode::kCorrupt, what, "weights, byte " + std::to_string(in.offset())};
}

Error unsupported(const char* what, uint32_t got, uint32_t expected, size_t offset) {
  return {ErrorCode::kUnsupported,
          what + (" " + std::to_string(got)) + ", expected " + std::to_string(expected),
          "weights, byte " + std::to_string(offset)};
}

Digest read_digest(ByteReader& in) {
  Digest digest;
  const auto bytes = in.bytes(digest.bytes.size());
  std::copy(bytes.begin(), bytes.end(), digest.bytes.begin());
  return digest;
}

bool good(float v) { return std::abs(v) <= kMaxValue; }  // NaN is not

}  // namespace

Bytes encode_weights(const WeightsFile& weights) {
  ByteWriter body;
  body.string(weights.id);
  body.string(weights.program);
  body.string(weights.scene);
  for (const Digest* d : {&weights.geometry, &weights.materials, &weights.lights})
    body.bytes(d->bytes);
  body.u32(weights.steps);
  body.u32(static_cast<uint32_t>(weights.held_out.size()));
  for (float v : weights.held_out) body.f32(v);
  body.u32(static_cast<uint32_t>(weights.network.values.size()));
  for (float v : weights.network.values) body.f32(v);
  ByteWriter out;
  out.u64(kMagic);
  out.u32(kWeightsFormatVersion);
  out.u32(kFeatureLayout);
  out.u32(crc32c(body.data()));
  out.bytes(body.data());
  return out.take();
}

std::string weights_id(WeightsFile weights) {
  weights.id.clear();
  return sha256(encode_weights(weights)).hex().substr(0, kIdHexDigits);
}

Result<WeightsFile> decode_weights(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  if (in.u64() != kMagic)
    return corrupt(in, "not qray's weights: the first 8 bytes are not QRAYRCV1");
  const uint32_t version = in.u32();
  if (version != kWeightsFormatVersion)
    return unsupported("weights format version", version, kWeightsFormatVersion, 8);
  if (const uint32_t layout = in.u32(); layout != kFeatureLayout)
    return unsupported("feature layout", layout, kFeatureLayout, 12);
  const uint32_t crc = in.u32();
  if (!in.ok()) return corrupt(in, "cut off in the header");
  if (crc32c(bytes.subspan(in.offset())) != crc) return corrupt(in, "the checksum is wrong");

  WeightsFile weights;
  weights.id = in.string(kMaxString);
  weights.program = in.string(kMaxString);
  weights.scene = in.string(kMaxString);
  for (Digest* d : {&weights.geometry, &weights.materials, &weights.lights}) *d = read_digest(in);
  weights.steps = in.u32();
  const uint32_t held_out = in.u32();
  if (held_out > kMaxHeldOut) return corrupt(in, "more than 4096 views kept apart");
  bool all_good = true;
  for (uint32_t i = 0; i < held_out && in.ok(); ++i) {
    weights.held_out.push_back(in.f32());
    all_good = all_good && good(weights.held_out.back()) && weights.held_out.back() >= 0;
  }
  const uint32_t size = in.u32();
  if (!in.ok() || size != pyramid_size() || in.remaining() != 4 * size_t{size})
    return corrupt(in, "expected " + std::to_string(pyramid_size()) + " values");
  for (uint32_t i = 0; i < size; ++i) {
    weights.network.values.push_back(in.f32());
    all_good = all_good && good(weights.network.values.back());
  }
  if (!all_good) return corrupt(in, "a value is not finite, or out of range");
  if (weights.id != weights_id(weights)) return corrupt(in, "its id is not that of its values");
  return weights;
}

}  // namespace qray
