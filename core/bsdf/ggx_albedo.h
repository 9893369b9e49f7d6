// How much GGX microfacets of Schlick's Fresnel reflect in all, by the cosine of wo and the
// roughness. Schlick's term is linear in its two colours, so two numbers tell it for any:
// f0 * at_f0 + f90 * at_f90 (Karis 2013, "Real Shading in Unreal Engine 4"). Made once, at first
// use; any thread.
#pragma once

#include <array>

#include "core/bsdf/ggx.h"

namespace qray {

inline float schlick_weight(float cosine) {
  const float x = std::clamp(1 - cosine, 0.0f, 1.0f), x2 = x * x;
  return x2 * x2 * x;
}

class GgxAlbedo {
 public:
  static const GgxAlbedo& table();

  struct Value {
    float at_f0 = 0, at_f90 = 0;
    // All of it where f0 = f90 = 1.
    float whole() const { return at_f0 + at_f90; }
    Rgb of(Rgb f0, Rgb f90) const { return f0 * at_f0 + f90 * at_f90; }
  };
  // Roughness 0 is a mirror.
  Value at(float roughness, float cosine) const {
    if (roughness <= 0) return {1 - schlick_weight(cosine), schlick_weight(cosine)};
    const Place r = place(roughness, kRows), c = place(std::sqrt(std::abs(cosine)), kCosines);
    const auto in_row = [&](int row) { return mix(c.share, nodes(row)[c.i], nodes(row)[c.i + 1]); };
    return mix(r.share, in_row(static_cast<int>(r.i)), in_row(static_cast<int>(r.i) + 1));
  }
  // Over a diffuse field of light, 2 int at mu dmu.
  Value mean(float roughness) const {
    if (roughness <= 0) return {20.0f / 21, 1.0f / 21};
    const Place r = place(roughness, kRows);
    return mix(r.share, means_[r.i], means_[r.i + 1]);
  }

 private:
  static constexpr int kRows = 65, kCosines = 65;  // nodes at 0 ... 1, both ends; of root cosines
  using Row = std::array<Value, kCosines>;
  struct Place {
    size_t i;
    float share;  // of the node after
  };
  GgxAlbedo();
  static Place place(float v, int count) {
    const float x = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(count - 1);
    const int i = std::min(static_cast<int>(x), count - 2);
    return {static_cast<size_t>(i), x - static_cast<float>(i)};
  }
  static Value mix(float t, Value a, Value b) {
    return {lerp(t, a.at_f0, b.at_f0), lerp(t, a.at_f90, b.at_f90)};
  }
  const Row& nodes(int row) const { return rows_[static_cast<size_t>(row)]; }

  std::array<Row, kRows> rows_;
  std::array<Value, kRows> means_;
};

}  // namespace qray
