#include "core/bsdf/coat_albedo.h"

namespace qray {
namespace {

constexpr int kTexturedRows = 24;
constexpr int kStrata = 24;  // squared: visible normals per entry

// The mean weight of reflections at visible normals, by the midpoint rule.
float coat_albedo(float ior, float roughness, float cos_o, Microfacets microfacets) {
  const Ggx ggx(roughness, microfacets);
  const Vec3 wo{std::sqrt(1 - sqr(cos_o)), 0, cos_o};
  double sum = 0;
  for (int i = 0; i < kStrata; ++i) {
    for (int j = 0; j < kStrata; ++j) {
      const Vec2 u{(static_cast<float>(i) + 0.5f) / kStrata,
                   (static_cast<float>(j) + 0.5f) / kStrata};
      const Vec3 h = ggx.sample(wo, u);
      const Vec3 wi = reflect(wo, h);
      if (wi.z > 0) sum += fresnel_dielectric(dot(wo, h), ior).reflectance * ggx.weight(h, wo, wi);
    }
  }
  return static_cast<float>(sum / (kStrata * kStrata));
}

}  // namespace

CoatAlbedo::CoatAlbedo(float ior, float roughness, bool textured, Microfacets microfacets)
    : rows_(textured ? kTexturedRows : 1), max_roughness_(roughness) {
  for (int r = 0; r < rows_; ++r) {
    const float rough =
        textured ? roughness * static_cast<float>(r) / static_cast<float>(rows_ - 1) : roughness;
    std::array<float, kCosines>& row = albedo_.emplace_back();
    for (int i = 0; i < kCosines; ++i) {
      const float cos_o = std::max(1e-4f, static_cast<float>(i) / (kCosines - 1));
      row[static_cast<size_t>(i)] = coat_albedo(ior, rough, cos_o, microfacets);
    }
    // Exact for the interpolant, segment by segment.
    constexpr double kStep = 1.0 / (kCosines - 1);
    double sum = 0;
    for (int i = 0; i + 1 < kCosines; ++i) {
      const double a = i * kStep, b = a + kStep;
      sum +=
          row[static_cast<size_t>(i)] * (2 * a + b) + row[static_cast<size_t>(i) + 1] * (a + 2 * b);
    }
    mean_.push_back(static_cast<float>(2 * sum * kStep / 6));
  }
}

}  // namespace qray
