// How much a rough dielectric coat reflects in all, by the cosine of wo and the roughness: a table
// made when a plastic is made, read by bilinear interpolation. With it the light that passes the
// coat is known exactly, so that coat and base together reflect no more than arrives, and a white
// base with a white coat all of it. Immutable; any thread.
#pragma once

#include <array>
#include <vector>

#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"

namespace qray {

class CoatAlbedo {
 public:
  // `textured`: the roughness varies in [0, roughness] over the surface.
  CoatAlbedo(float ior, float roughness, bool textured,
             Microfacets microfacets = Microfacets::kGgx);

  struct Row {
    int row;
    float share;  // of the row after
  };
  // The place of a roughness, for the calls below.
  Row row(float roughness) const {
    if (rows_ == 1) return {0, 0};
    const float r =
        std::clamp(roughness / max_roughness_, 0.0f, 1.0f) * static_cast<float>(rows_ - 1);
    const int i = std::min(static_cast<int>(r), rows_ - 2);
    return {i, r - static_cast<float>(i)};
  }
  float albedo(Row row, float cos_o) const {
    const float t = std::clamp(cos_o, 0.0f, 1.0f) * (kCosines - 1);
    const int i = std::min(static_cast<int>(t), kCosines - 2);
    const float share = t - static_cast<float>(i);
    const auto at = [&](int r) {
      const std::array<float, kCosines>& a = albedo_[static_cast<size_t>(r)];
      return lerp(share, a[static_cast<size_t>(i)], a[static_cast<size_t>(i) + 1]);
    };
    return row.share == 0 ? at(row.row) : lerp(row.share, at(row.row), at(row.row + 1));
  }
  // Over a diffuse field of light, 2 int albedo mu dmu.
  float mean(Row row) const {
    const size_t i = static_cast<size_t>(row.row);
    return row.share == 0 ? mean_[i] : lerp(row.share, mean_[i], mean_[i + 1]);
  }

 private:
  static constexpr int kCosines = 64;  // nodes at 0, 1/63 ... 1
  int rows_;
  float max_roughness_;
  std::vector<std::array<float, kCosines>> albedo_;
  std::vector<float> mean_;
};

}  // namespace qray
