// A point of a surface, seen from wo: what a Bsdf is asked about. One is made at each vertex of a
// path; the vertex's eval, sample and parts share what it keeps.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

#include "core/math/vec.h"

namespace qray {

// The material's parameters at one point, textures looked up; each as Material has it.
struct ShadingPoint {
  Rgb reflectance;
  float roughness = 0, anisotropy = 0;
  Rgb specular{1.0f}, transmittance{1.0f};
  Rgb sheen{};
  float sheen_roughness = 0;
  float metallic = 0, transmission = 0, clearcoat = 0, clearcoat_roughness = 0, specular_weight = 1;
  float diffuse_transmission = 0;
  Rgb diffuse_transmission_color{1.0f};
  float iridescence = 0, film_nm = 0;
  Vec3 coat_normal{0, 0, 1};  // local, above the surface
};

class BsdfPoint {
 public:
  // Keeps nothing yet. Others than Bsdf::at() may do so for Lambert surfaces alone, which need
  // nothing. The ShadingPoint outlives this: it is not copied, since most are a material's own.
  BsdfPoint(const ShadingPoint& sp_, Vec3 wo_) : sp(sp_), wo(wo_) {}
  BsdfPoint(ShadingPoint&&, Vec3) = delete;

  const ShadingPoint& sp;
  Vec3 wo;

  // Room for what a kind of BSDF computes from both: one T, which its prepare() sets and its other
  // calls read.
  template <class T>
  void keep(const T& value) {
    check_fits<T>();
    std::construct_at(reinterpret_cast<T*>(kept_), value);
  }
  template <class T>
  const T& kept() const {
    check_fits<T>();
    return *std::launder(reinterpret_cast<const T*>(kept_));
  }

 private:
  static constexpr size_t kRoomBytes = 160;
  template <class T>
  static constexpr void check_fits() {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= kRoomBytes &&
                  alignof(T) <= alignof(float));
  }

  alignas(float) std::byte kept_[kRoomBytes];  // not zeroed: that would cost every vertex
};

}  // namespace qray
