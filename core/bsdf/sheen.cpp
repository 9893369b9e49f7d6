#include "core/bsdf/sheen.h"

namespace qray {
namespace {

// Below it is a line at the silhouette that floats cannot follow.
constexpr float kLeastAlpha = 0.005f;

float to_alpha(float roughness) { return std::max(sqr(roughness), kLeastAlpha); }

// The paper's fit of lambda, eq. 3, between its coefficients for alpha 0 and 1.
float lambda(float cosine, float alpha) {
  const float t = sqr(1 - alpha);
  const float a = lerp(t, 21.5473f, 25.3245f), b = lerp(t, 3.82987f, 3.32435f),
              c = lerp(t, 0.19823f, 0.16801f), d = lerp(t, -1.97760f, -1.27393f),
              e = lerp(t, -4.32054f, -4.85967f);
  const auto fit = [&](float x) { return a / (1 + b * std::pow(x, c)) + d * x + e; };
  return std::exp(cosine < 0.5f ? fit(cosine) : 2 * fit(0.5f) - fit(1 - cosine));
}

float unbounded_f(Vec3 wo, Vec3 wi, float roughness) {
  const float alpha = to_alpha(roughness);
  const Vec3 h = normalize(wo + wi);
  const float sin2 = std::max(0.0f, 1 - sqr(h.z));
  const float d = (2 + 1 / alpha) * std::pow(sin2, 0.5f / alpha) / (2 * kPi);
  return d / ((1 + lambda(wo.z, alpha) + lambda(wi.z, alpha)) * 4 * wo.z * wi.z);
}

}  // namespace

const Sheen& Sheen::table() {
  static const Sheen table;
  return table;
}

Sheen::Sheen() {
  constexpr int kSteps = 32;  // over the azimuth's half, and over the height's root
  for (size_t r = 0; r < kNodes; ++r) {
    for (size_t c = 0; c < kNodes; ++c) {
      const float z = std::max(1e-3f, sqr(static_cast<float>(c) / (kNodes - 1)));
      const Vec3 wo{std::sqrt(1 - sqr(z)), 0, z};
      double sum = 0;
      for (int i = 0; i < kSteps * kSteps; ++i) {
        const float root = (static_cast<float>(i / kSteps) + 0.5f) / kSteps, cos_i = sqr(root);
        const float phi = kPi * (static_cast<float>(i % kSteps) + 0.5f) / kSteps;
        const float sin_i = std::sqrt(1 - sqr(cos_i));
        const Vec3 wi{sin_i * std::cos(phi), sin_i * std::sin(phi), cos_i};
        const float f = unbounded_f(wo, wi, static_cast<float>(r) / (kNodes - 1));
        sum += static_cast<double>(f * cos_i * 2 * root);
      }
      albedos_[r][c] = static_cast<float>(sum / (kSteps * kSteps) * 2 * std::numbers::pi);
    }
  }
}

float Sheen::unbounded_albedo(float cosine, float roughness) const {
  const auto place = [](float v, size_t& i) {
    const float x = std::clamp(v, 0.0f, 1.0f) * (kNodes - 1);
    i = std::min(static_cast<size_t>(x), static_cast<size_t>(kNodes - 2));
    return x - static_cast<float>(i);
  };
  size_t r, c;
  const float of_row = place(roughness, r), of_cosine = place(std::sqrt(std::abs(cosine)), c);
  const auto in_row = [&](size_t row) {
    return lerp(of_cosine, albedos_[row][c], albedos_[row][c + 1]);
  };
  return lerp(of_row, in_row(r), in_row(r + 1));
}

float Sheen::f(Vec3 wo, Vec3 wi, float roughness) const {
  const float least = 1e-4f;
  if (wo.z < least || wi.z < least) return 0;
  const float too_much =
      std::max({1.0f, unbounded_albedo(wo.z, roughness), unbounded_albedo(wi.z, roughness)});
  return unbounded_f(wo, wi, roughness) / too_much;
}

}  // namespace qray
