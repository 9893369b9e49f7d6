// Maps 64-bit state keys to dense indices 0, 1, 2... in the order of insertion. Open addressing
// with linear probing at most half full; one cache line a lookup in most cases. Not synchronised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/math/hash.h"

namespace qray {

class KeyIndex {
 public:
  static constexpr size_t kMinSlots = 1024, kSlotBytes = 16;
  // Memory is at most kMinBytes + kMaxBytesPerKey for each key: slots are doubled when half are
  // taken, and so is the list of keys when it is full.
  static constexpr size_t kMinBytes = kMinSlots * kSlotBytes;
  static constexpr size_t kMaxBytesPerKey = 4 * kSlotBytes + 2 * sizeof(uint64_t);

  StateId find(uint64_t key) const {
    if (slots_.empty()) return StateId();
    for (size_t i = mix64(key) & mask();; i = (i + 1) & mask()) {
      if (slots_[i].index == StateId::kNoneValue) return StateId();
      if (slots_[i].key == key) return StateId(slots_[i].index);
    }
  }

  StateId find_or_insert(uint64_t key) {
    if (2 * (keys_.size() + 1) > slots_.size()) grow();
    for (size_t i = mix64(key) & mask();; i = (i + 1) & mask()) {
      if (slots_[i].index == StateId::kNoneValue) {
        slots_[i] = {key, static_cast<uint32_t>(keys_.size())};
        keys_.push_back(key);
      }
      if (slots_[i].key == key) return StateId(slots_[i].index);
    }
  }

  size_t size() const { return keys_.size(); }
  const std::vector<uint64_t>& keys() const { return keys_; }  // by index
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.slots_, self.keys_);
  }
  size_t bytes() const { return slots_.capacity() * sizeof(Slot) + keys_.capacity() * 8; }

 private:
  struct Slot {
    uint64_t key = 0;
    uint32_t index = StateId::kNoneValue;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.key, self.index);
    }
  };
  static_assert(sizeof(Slot) == kSlotBytes);
  size_t mask() const { return slots_.size() - 1; }
  void grow() {
    slots_.assign(slots_.empty() ? kMinSlots : slots_.size() * 2, {});
    for (size_t k = 0; k < keys_.size(); ++k) {
      size_t i = mix64(keys_[k]) & mask();
      while (slots_[i].index != StateId::kNoneValue) i = (i + 1) & mask();
      slots_[i] = {keys_[k], static_cast<uint32_t>(k)};
    }
  }

  std::vector<Slot> slots_;
  std::vector<uint64_t> keys_;
};

}  // namespace qray
