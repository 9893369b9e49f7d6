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
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *at;
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<uint16_t>(at);
  return load<uint32_t>(at);
}

size_t component_bytes(int type) {
  return static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type)));
}

}  // namespace

GltfAccessor::GltfAccessor(GltfImport& import, int accessor, int components, size_t max_count)
    : document_(import.document),
      index_(accessor),
      accessor_(document_.model().accessors[static_cast<size_t>(accessor)]),
      components_(static_cast<size_t>(components)) {
  if (accessor_.type != (components == 1 ? TINYGLTF_TYPE_SCALAR : components))
    node().get("type").fail_expected(components == 1 ? "SCALAR"
                                                     : "VEC" + std::to_string(components));
  if (count() > max_count)
    node().get("count").fail(
        "expected at most " + std::to_string(max_count) + ", got " + std::to_string(count()),
        ErrorCode::kTooLarge);
  const size_t size = component_bytes(accessor_.componentType) * components_;
  if (accessor_.bufferView >= 0)
    base_ = find_elements(accessor_.bufferView, accessor_.byteOffset, count(), size, node());
  if (!accessor_.sparse.isSparse) return;

  const JsonNode sparse = node().get("sparse");
  const auto& indices = accessor_.sparse.indices;
  const auto& values = accessor_.sparse.values;
  const auto changed = static_cast<size_t>(accessor_.sparse.count);
  if (changed > import.sparse_left)
    sparse.get("count").fail("too many sparse elements in all", ErrorCode::kTooLarge);
  import.sparse_left -= changed;
  const size_t index_size = component_bytes(indices.componentType);
  const Elements at = find_elements(indices.bufferView, static_cast<size_t>(indices.byteOffset),
                                    changed, index_size, sparse.get("indices"));
  sparse_ = find_elements(values.bufferView, static_cast<size_t>(values.byteOffset), changed, size,
                          sparse.get("values"));
  for (size_t i = 0; i < changed; ++i) {
    const uint32_t index = load_index(at.data + i * at.stride, indices.componentType);
    if (index >= count() || (i > 0 && index <= sparse_indices_.back()))
      sparse.get("indices").fail("expected ascending indices below " + std::to_string(count()) +
                                 ", got " + std::to_string(index) + " at " + std::to_string(i));
    sparse_indices_.push_back(index);
  }
}

GltfAccessor::Elements GltfAccessor::find_elements(int view, size_t offset, size_t count,
                                                   size_t element_bytes,
                                                   const JsonNode& place) const {
  const std::span<const uint8_t> bytes = document_.view_bytes(view);
  const size_t given = document_.model().bufferViews[static_cast<size_t>(view)].byteStride;
  const size_t stride = given > 0 ? given : element_bytes;
  // All of them below 2^31: the sum does not overflow.
  const size_t end = offset + (count - 1) * stride + element_bytes;
  if (end > bytes.size()) {
    place.fail("expected " + std::to_string(end) + " bytes in bufferView " + std::to_string(view) +
               ", got " + std::to_string(bytes.size()));
  }
  return {bytes.data() + offset, stride};
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
    switch (accessor_.componentType) {
      case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const float v = load<int8_t>(element + c);
        out[c] = norm ? std::max(v / 127, -1.0f) : v;
        break;
      }
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        out[c] = static_cast<float>(element[c]) / (norm ? 255.0f : 1.0f);
        break;
      case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const float v = load<int16_t>(element + 2 * c);
        out[c] = norm ? std::max(v / 32767, -1.0f) : v;
        break;
      }
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        out[c] = static_cast<float>(load<uint16_t>(element + 2 * c)) / (norm ? 65535.0f : 1.0f);
        break;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
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
      floats == components_ && accessor_.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
    std::memcpy(out, base_.data, count() * size);
    return;
  }
  const size_t n = wanted.empty() ? count() : wanted.size();
  for (size_t i = 0; i < n; ++i) {
    float values[4] = {0, 0, 0, 0};
    if (const uint8_t* at = element(wanted.empty() ? static_cast<uint32_t>(i) : wanted[i]))
      decode(at, values);
    std::copy_n(values, floats, out + i * floats);
  }
}

std::vector<uint32_t> GltfAccessor::read_indices() const {
  const int type = accessor_.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    node().get("componentType").fail_expected("5121, 5123 or 5125");
  std::vector<uint32_t> out(count());
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT && sparse_indices_.empty() &&
      base_.stride == sizeof(uint32_t)) {
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
