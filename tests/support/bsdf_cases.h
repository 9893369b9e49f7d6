// The surfaces and directions that every Bsdf test goes through.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/bsdf/bsdf.h"

namespace qray::test {

struct BsdfCase {
  std::string name;
  Material material;
  ShadingPoint point;
  std::unique_ptr<Bsdf> bsdf;
};

inline Material material_of(MaterialKind kind, float roughness, float ior = 1.5f) {
  Material m;
  m.kind = kind;
  m.roughness.value = roughness;
  m.ior = ior;
  m.reflectance.value = {0.7f, 0.4f, 0.2f};
  return m;
}

inline BsdfCase make_case(std::string name, const Material& m) {
  return {std::move(name), m, {m.reflectance.value, m.roughness.value}, make_bsdf(m)};
}

// Every kind that has a density.
inline std::vector<BsdfCase> density_cases() {
  std::vector<BsdfCase> cases;
  const auto add = [&](const char* name, MaterialKind kind, float roughness, float ior = 1.5f) {
    cases.push_back(make_case(std::string(name) + " roughness " + std::to_string(roughness) +
                                  " ior " + std::to_string(ior),
                              material_of(kind, roughness, ior)));
  };
  add("diffuse", MaterialKind::kDiffuse, 0);
  for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
    add("conductor", MaterialKind::kConductor, roughness);
    add("dielectric", MaterialKind::kDielectric, roughness);
    add("plastic", MaterialKind::kPlastic, roughness);
  }
  add("dielectric", MaterialKind::kDielectric, 0.5f, 1.05f);
  add("dielectric", MaterialKind::kDielectric, 0.5f, 2.4f);
  add("plastic", MaterialKind::kPlastic, 0.0f);
  return cases;
}

inline Vec3 direction(float theta_deg, float phi_deg) {
  const float t = theta_deg * kPi / 180, p = phi_deg * kPi / 180;
  return normalize({std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)});
}
// Above and below, steep and grazing.
inline std::vector<Vec3> eye_directions() {
  return {direction(0, 0),    direction(30, 50),   direction(60, 200),
          direction(80, 300), direction(89, 10),   direction(180, 0),
          direction(140, 70), direction(100, 250), direction(91, 120)};
}

inline std::string text(Vec3 w) {
  return "(" + std::to_string(w.x) + ", " + std::to_string(w.y) + ", " + std::to_string(w.z) + ")";
}

}  // namespace qray::test
