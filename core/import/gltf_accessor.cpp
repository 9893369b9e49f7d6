#include "core/import/gltf_accessor.h"

#include <algorithm>

namespace qray {
namespace {

template <class T>
T load(const uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

uint32_t load_index(const uint8_t* at, int component_type) {
  if (component_type == kGltfUnsignedByte) return *at;
  if (component_type == kGltfUnsignedShort) return load<uint16_t>(at);
  return load<uint32_t>(at);
}

size_t component_bytes(int type) {
  if (type == kGltfByte || type == kGltfUnsignedByte) return 1;
  return type == kGltfShort || type == kGltfUnsignedShort ? 2 : 4;
}

}  // namespace

GltfAccessor::GltfAccessor(GltfImport& import, int accessor, int components, size_t max_count)
    : GltfAccessor(import, accessor,
                   import.document.model().accessors[static_cast<size_t>(accessor)], components,
                   max_count) {}

GltfAccessor::GltfAccessor(GltfImport& import, int accessor, const GltfModel::Accessor& unpacked,
                           int components, size_t max_count)
    : document_(import.document),
      index_(accessor),
      accessor_(unpacked),
      components_(static_cast<size_t>(components)) {
  if (accessor_.components != components)
    node().get("type").fail_expected(components == 1    ? "SCALAR"
                                     : components == 16 ? "MAT4"
                                                        : "VEC" + std::to_string(components));
  if (count() > max_count)
    node().get("count").fail(
        "expected at most " + std::to_string(max_count) + ", got " + std::to_string(count()),
        ErrorCode::kTooLarge);
  const size_t size = component_bytes(accessor_.elements.component_type) * components_;
  if (accessor_.elements.view >= 0)
    base_ = find_elements(accessor_.elements, count(), size, node());
  const size_t changed = accessor_.sparse_count;
  if (changed == 0) return;

  const JsonNode sparse = node().get("sparse");
  if (changed > import.sparse_left)
    sparse.get("count").fail("too many sparse elements in all", ErrorCode::kTooLarge);
  import.sparse_left -= changed;
  const int index_type = accessor_.sparse_indices.component_type;
  const Elements at = find_elements(accessor_.sparse_indices, changed, component_bytes(index_type),
                                    sparse.get("indices"));
  sparse_ = find_elements(accessor_.sparse_values, changed, size, sparse.get("values"));
  for (size_t i = 0; i < changed; ++i) {
    const uint32_t index = load_index(at.data + i * at.stride, index_type);
    if (index >= count() || (i > 0 && index <= sparse_indices_.back()))
      sparse.get("indices").fail("expected ascending indices below " + std::to_string(count()) +
                                 ", got " + std::to_string(index) + " at " + std::to_string(i));
    sparse_indices_.push_back(index);
  }
}

GltfAccessor::Elements GltfAccessor::find_elements(const GltfModel::Part& part, size_t count,
                                                   size_t element_bytes,
                                                   const JsonNode& place) const {
  const std::span<const uint8_t> bytes = document_.view_bytes(part.view);
  const size_t given = document_.model().views[static_cast<size_t>(part.view)].byte_stride;
  const size_t stride = given > 0 ? given : element_bytes;
  // All of them below 2^31: the sum does not overflow.
  const size_t end = part.byte_offset + (count - 1) * stride + element_bytes;
  if (end > bytes.size()) {
    place.fail("expected " + std::to_string(end) + " bytes in bufferView " +
               std::to_string(part.view) + ", got " + std::to_string(bytes.size()));
  }
  return {bytes.data() + part.byte_offset, stride};
}

const uint8_t* GltfAccessor::element(uint32_t i) const {
  if (!sparse_indices_.empty()) {
    const auto it = std::lower_bound(sparse_indices_.begin(), sparse_indices_.end(), i);
    if (it != sparse_indices_.end() && *it == i)
      return sparse_.data + static_cast<size_t>(it - sparse_indices_.begin()) * sparse_.stride;
  }
  return base_.data ? base_.data + i * base_.stride : nullptr;
}

void GltfAccessor::decode(const uint8_t* element, float* out) const {
  const bool norm = accessor_.normalized;
  for (size_t c = 0; c < components_; ++c) {
    switch (accessor_.elements.component_type) {
      case kGltfByte: {
        const float v = load<int8_t>(element + c);
        out[c] = norm ? std::max(v / 127, -1.0f) : v;
        break;
      }
      case kGltfUnsignedByte:
        out[c] = static_cast<float>(element[c]) / (norm ? 255.0f : 1.0f);
        break;
      case kGltfShort: {
        const float v = load<int16_t>(element + 2 * c);
        out[c] = norm ? std::max(v / 32767, -1.0f) : v;
        break;
      }
      case kGltfUnsignedShort:
        out[c] = static_cast<float>(load<uint16_t>(element + 2 * c)) / (norm ? 65535.0f : 1.0f);
        break;
      case kGltfUnsignedInt:
        out[c] = static_cast<float>(load<uint32_t>(element + 4 * c));
        break;
      default:
        out[c] = load<float>(element + 4 * c);
    }
  }
}

// `floats` of each element.
void GltfAccessor::read_floats(std::span<const uint32_t> wanted, float* out, size_t floats) const {
  const size_t size = sizeof(float) * components_;
  if (wanted.empty() && sparse_indices_.empty() && base_.data && base_.stride == size &&
      floats == components_ && accessor_.elements.component_type == kGltfFloat) {
    std::memcpy(out, base_.data, count() * size);
    return;
  }
  const size_t n = wanted.empty() ? count() : wanted.size();
  for (size_t i = 0; i < n; ++i) {
    float values[16] = {};
    if (const uint8_t* at = element(wanted.empty() ? static_cast<uint32_t>(i) : wanted[i]))
      decode(at, values);
    std::copy_n(values, floats, out + i * floats);
  }
}

std::vector<uint32_t> GltfAccessor::read_indices() const {
  const int type = accessor_.elements.component_type;
  if (type != kGltfUnsignedByte && type != kGltfUnsignedShort && type != kGltfUnsignedInt)
    node().get("componentType").fail_expected("5121, 5123 or 5125");
  std::vector<uint32_t> out(count());
  if (type == kGltfUnsignedInt && sparse_indices_.empty() && base_.stride == sizeof(uint32_t)) {
    std::memcpy(out.data(), base_.data, count() * sizeof(uint32_t));
    return out;
  }
  for (size_t i = 0; i < count(); ++i) {
    const uint8_t* at = element(static_cast<uint32_t>(i));
    out[i] = at ? load_index(at, type) : 0;
  }
  return out;
}

}  // namespace qray
