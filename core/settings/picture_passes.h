// The pictures beside the beauty that a job may be asked for, and by what its light is told apart.
// Pure.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

namespace qray {

enum class PicturePass : uint8_t {
  kAlbedo,
  kNormal,
  kGeometricNormal,
  kDepth,
  kPosition,
  kUv,
  kMeshId,
  kMaterialId,
  kMotion,
  kCryptomatteObject,
  kCryptomatteMaterial,
  kDirect,
  kIndirect,
  kBounces,
  kEmission,
  kSamples,
  kVariance,
  kSampled,
  kRecovered,
};
// As a job and the command call them, by the value.
inline constexpr std::array<std::string_view, 19> kPicturePassNames{"albedo",
                                                                    "normal",
                                                                    "geometric-normal",
                                                                    "depth",
                                                                    "position",
                                                                    "uv",
                                                                    "mesh-id",
                                                                    "material-id",
                                                                    "motion",
                                                                    "cryptomatte-object",
                                                                    "cryptomatte-material",
                                                                    "direct",
                                                                    "indirect",
                                                                    "bounces",
                                                                    "emission",
                                                                    "samples",
                                                                    "variance",
                                                                    "sampled",
                                                                    "recovered"};

constexpr int kMostBounces = 8;  // that have a layer each

// Numbers a pixel, at most.
constexpr size_t pass_channels(PicturePass pass) {
  switch (pass) {
    case PicturePass::kDepth:
    case PicturePass::kMeshId:
    case PicturePass::kMaterialId:
    case PicturePass::kSamples:
    case PicturePass::kVariance:
      return 1;
    case PicturePass::kUv:
      return 2;
    case PicturePass::kMotion:
      return 4;
    case PicturePass::kCryptomatteObject:
    case PicturePass::kCryptomatteMaterial:
      return 12;
    case PicturePass::kBounces:
      return 3 * kMostBounces;
    default:
      return 3;
  }
}

class PicturePasses {
 public:
  bool has(PicturePass pass) const { return (bits_ & bit(pass)) != 0; }
  bool has_any(std::initializer_list<PicturePass> passes) const {
    return std::ranges::any_of(passes, [this](PicturePass pass) { return has(pass); });
  }
  bool empty() const { return bits_ == 0; }
  void add(PicturePass pass) { bits_ |= bit(pass); }
  // One by its name, or "all". False: there is no such pass.
  bool add(std::string_view name) {
    if (name == "all") {
      bits_ = (1u << kPicturePassNames.size()) - 1;
      return true;
    }
    const auto* const found = std::ranges::find(kPicturePassNames, name);
    if (found == kPicturePassNames.end()) return false;
    add(static_cast<PicturePass>(found - kPicturePassNames.begin()));
    return true;
  }
  bool operator==(const PicturePasses&) const = default;

 private:
  static uint32_t bit(PicturePass pass) { return 1u << static_cast<unsigned>(pass); }
  uint32_t bits_ = 0;
};

// Into how many layers light goes by how often it was scattered, on paths of at most so many
// surfaces: with kBounces one for each number up to kMostBounces, whose layer has all beyond too.
inline int bounce_layers(const PicturePasses& passes, int max_depth) {
  if (passes.has(PicturePass::kBounces)) return std::clamp(max_depth - 1, 2, kMostBounces);
  return passes.has_any({PicturePass::kDirect, PicturePass::kIndirect}) ? 2 : 0;
}

// What makes the lights of a scene one group, whose light the film keeps apart.
enum class LightGrouping : uint8_t {
  kNone,      // the film keeps no groups
  kScene,     // the name that the scene gives the group
  kMaterial,  // the material that emits
  kName,      // the name of the mesh
  kEach,      // nothing: each mesh is one
};
inline constexpr std::array<std::string_view, 5> kLightGroupingNames{"none", "scene", "material",
                                                                     "name", "each"};
inline std::optional<LightGrouping> light_grouping_named(std::string_view name) {
  const auto* const found = std::ranges::find(kLightGroupingNames, name);
  if (found == kLightGroupingNames.end()) return std::nullopt;
  return static_cast<LightGrouping>(found - kLightGroupingNames.begin());
}

constexpr size_t kMaxLightGroups = 64;

}  // namespace qray
