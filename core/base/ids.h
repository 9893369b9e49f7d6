// Strong integer ids: a MeshId cannot be passed where a MaterialId is meant.
#pragma once

#include <compare>
#include <cstdint>

namespace qray {

template <class Tag>
struct Id {
  static constexpr uint32_t kNoneValue = 0xffffffffu;
  uint32_t value = kNoneValue;

  constexpr Id() = default;
  constexpr explicit Id(uint32_t v) : value(v) {}
  constexpr bool valid() const { return value != kNoneValue; }
  auto operator<=>(const Id&) const = default;
};

using MeshId = Id<struct MeshTag>;
using MaterialId = Id<struct MaterialTag>;
using TextureId = Id<struct TextureTag>;
using StateId = Id<struct StateTag>;  // a state of a guide's table

}  // namespace qray
