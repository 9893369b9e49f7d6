// The elements of glTF accessors as floats and indices: all component types, normalized or not,
// interleaved, sparse. That their bytes are there is checked before anything is read. Throws
// ImportFailure. One thread.
#pragma once

#include <cstring>

#include "core/import/gltf_import.h"

namespace qray {

class GltfAccessor {
 public:
  // Fails unless the accessor has so many components and at most `max_count` elements.
  GltfAccessor(GltfImport& import, int accessor, int components, size_t max_count);
  // The same with its elements where they were unpacked to.
  GltfAccessor(GltfImport& import, int accessor, const GltfModel::Accessor& unpacked,
               int components, size_t max_count);

  size_t count() const { return accessor_.count; }
  JsonNode node() const { return document_.at("accessors", index_); }
  size_t components() const { return components_; }
  // `wanted` elements, or all where it is empty, as vectors of floats; what a vector has more than
  // the accessor is 0.
  template <class V>
  std::vector<V> read(std::span<const uint32_t> wanted = {}) const {
    std::vector<V> out(wanted.empty() ? count() : wanted.size());
    static_assert(std::is_trivially_copyable_v<V>);
    read_floats(wanted, reinterpret_cast<float*>(out.data()), sizeof(V) / sizeof(float));
    return out;
  }
  std::vector<uint32_t> read_indices() const;  // pre: 1 component

 private:
  // Elements in a buffer view.
  struct Elements {
    const uint8_t* data = nullptr;  // null: zeros
    size_t stride = 0;
  };
  Elements find_elements(const GltfModel::Part& part, size_t count, size_t element_bytes,
                         const JsonNode& place) const;
  void read_floats(std::span<const uint32_t> wanted, float* out, size_t floats) const;
  void decode(const uint8_t* element, float* out) const;
  const uint8_t* element(uint32_t i) const;  // null: zeros

  const GltfDocument& document_;
  int index_;
  GltfModel::Accessor accessor_;
  size_t components_;
  Elements base_, sparse_;
  std::vector<uint32_t> sparse_indices_;  // that sparse_ replaces, ascending
};

}  // namespace qray
