#include "core/bsdf/ggx_albedo.h"

namespace qray {

const GgxAlbedo& GgxAlbedo::table() {
  static const GgxAlbedo table;
  return table;
}

GgxAlbedo::GgxAlbedo() {
  constexpr int kStrata = 20;  // squared: visible normals per node
  const auto root = [](size_t node) { return static_cast<double>(node) / (kCosines - 1); };
  for (size_t r = 0; r < rows_.size(); ++r) {
    const Ggx ggx(static_cast<float>(r) / (kRows - 1));
    for (size_t c = 0; c < rows_[r].size(); ++c) {
      const float z = std::max(1e-4f, static_cast<float>(root(c) * root(c)));
      const Vec3 wo{std::sqrt(1 - sqr(z)), 0, z};
      double at_f0 = 0, at_f90 = 0;
      for (int i = 0; i < kStrata * kStrata; ++i) {
        const Vec2 u{(static_cast<float>(i / kStrata) + 0.5f) / kStrata,
                     (static_cast<float>(i % kStrata) + 0.5f) / kStrata};
        const Vec3 h = ggx.sample_visible(wo, u), wi = reflect(wo, h);
        if (wi.z <= 0) continue;
        const float kept = ggx.g2_over_g1(wo, wi), schlick = schlick_weight(dot(wo, h));
        at_f0 += kept * (1 - schlick);
        at_f90 += kept * schlick;
      }
      constexpr double kCount = kStrata * kStrata;
      rows_[r][c] = {static_cast<float>(at_f0 / kCount), static_cast<float>(at_f90 / kCount)};
    }
    // Exact for the interpolant, segment by segment.
    Value& mean = means_[r];
    for (size_t c = 0; c + 1 < kCosines; ++c) {
      // int 2 mu dmu over root cosines s in [a, b], mu = s^2, of what falls linearly from 1 to 0.
      const double a = root(c), b = root(c + 1), width = b - a;
      const auto moment = [&](int n) { return (std::pow(b, n) - std::pow(a, n)) / n; };
      const float before = static_cast<float>(4 * (b * moment(4) - moment(5)) / width);
      const float after = static_cast<float>(4 * (moment(5) - a * moment(4)) / width);
      mean.at_f0 += rows_[r][c].at_f0 * before + rows_[r][c + 1].at_f0 * after;
      mean.at_f90 += rows_[r][c].at_f90 * before + rows_[r][c + 1].at_f90 * after;
    }
  }
}

}  // namespace qray
