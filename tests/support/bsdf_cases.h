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
  bool reciprocal = true;  // but for refraction

  BsdfPoint at(Vec3 wo) const { return bsdf->at(point, wo); }
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
  return {std::move(name), m, constant_point(m), make_bsdf(m)};
}

// The principled kind's parameters at their ends and between.
inline std::vector<BsdfCase> principled_cases() {
  std::vector<BsdfCase> cases;
  const auto add = [&](const char* name, float roughness, auto change) {
    Material m = material_of(MaterialKind::kPrincipled, roughness);
    change(m);
    cases.push_back(make_case(std::string("principled ") + name, m));
  };
  add("dielectric", 0.4f, [](Material&) {});
  add("metal", 0.3f, [](Material& m) { m.metallic.value = 1; });
  add("half metal", 0.7f, [](Material& m) { m.metallic.value = 0.5f; });
  add("coloured specular", 0.5f, [](Material& m) {
    m.specular.value = {3, 1, 20};
    m.specular_weight.value = 0.8f;
  });
  add("no specular", 0.5f, [](Material& m) { m.specular_weight.value = 0; });
  add("glass", 0.4f, [](Material& m) { m.transmission.value = 1; });
  add("half glass", 0.6f, [](Material& m) {
    m.transmission.value = 0.5f;
    m.ior = 1.3f;
  });
  add("sheet", 0.5f, [](Material& m) {
    m.transmission.value = 0.7f;
    m.thin = true;
  });
  add("smooth", 0, [](Material&) {});
  add("smooth half glass", 0, [](Material& m) { m.transmission.value = 0.5f; });
  add("smooth coat", 0.5f, [](Material& m) { m.clearcoat.value = 1; });
  add("rough coat", 0.7f, [](Material& m) {
    m.metallic.value = 0.3f;
    m.clearcoat.value = 0.8f;
    m.clearcoat_roughness.value = 0.25f;
  });
  add("cloth", 0.8f, [](Material& m) {
    m.sheen.value = {0.9f, 0.5f, 1};
    m.sheen_roughness.value = 0.4f;
  });
  add("smooth cloth under a coat", 0, [](Material& m) {
    m.sheen.value = Rgb{0.6f};
    m.sheen_roughness.value = 1;
    m.clearcoat.value = 0.5f;
  });
  add("brushed metal", 0.2f, [](Material& m) {
    m.metallic.value = 1;
    m.anisotropy.value = 0.7f;
  });
  add("brushed dielectric", 0.4f, [](Material& m) { m.anisotropy.value = 0.6f; });
  add("brushed half glass", 0.3f, [](Material& m) {
    m.anisotropy.value = 0.5f;
    m.transmission.value = 0.5f;
  });
  add("leaf", 0.5f, [](Material& m) {
    m.diffuse_transmission.value = 0.6f;
    m.diffuse_transmission_color.value = {0.2f, 0.9f, 0.4f};
    m.thin = true;
  });
  add("smooth leaf of half glass under a coat", 0, [](Material& m) {
    m.diffuse_transmission.value = 0.4f;
    m.transmission.value = 0.5f;
    m.thin = true;
    m.clearcoat.value = 0.6f;
    m.clearcoat_roughness.value = 0.3f;
  });
  add("film", 0.4f, [](Material& m) { m.iridescence.value = 1; });
  add("film on metal", 0.3f, [](Material& m) {
    m.metallic.value = 0.8f;
    m.iridescence.value = 0.7f;
    m.film_ior = 1.8f;
    m.film_nm.value = 250;
  });
  add("film on half glass", 0.3f, [](Material& m) {
    m.transmission.value = 0.5f;
    m.iridescence.value = 1;
    m.film_nm.value = 550;
  });
  add("Disney", 0.6f, [](Material& m) {
    m.disney = true;
    m.sheen.value = {0.5f, 1.4f, 0.2f};
  });
  add("Disney's half glass under a coat", 0.3f, [](Material& m) {
    m.disney = true;
    m.metallic.value = 0.2f;
    m.transmission.value = 0.5f;
    m.clearcoat.value = 0.25f;
    m.clearcoat_roughness.value = 0.3f;
  });
  for (const float roughness : {0.0f, 0.3f}) {
    add("tilted coat", 0.5f, [&](Material& m) {
      m.clearcoat.value = 0.9f;
      m.clearcoat_roughness.value = roughness;
    });
    cases.back().point.coat_normal = normalize(Vec3{0.3f, -0.2f, 1});
    cases.back().reciprocal = false;
  }
  add("all", 0.3f, [](Material& m) {
    m.metallic.value = 0.2f;
    m.transmission.value = 0.5f;
    m.clearcoat.value = 0.5f;
    m.clearcoat_roughness.value = 0.6f;
    m.sheen.value = {0.2f, 1, 0.7f};
    m.sheen_roughness.value = 0.15f;
  });
  return cases;
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
  for (const float roughness : {0.0f, 0.4f}) {
    Material m = material_of(MaterialKind::kPlastic, roughness);
    m.nonlinear = false;
    cases.push_back(make_case("linear plastic roughness " + std::to_string(roughness), m));
  }
  for (const float transmittance : {0.0f, 0.3f}) {
    Material m = material_of(MaterialKind::kDielectric, 0.5f);
    m.specular.value = {0.5f, 0.9f, 0.2f};
    m.transmittance.value = Rgb{transmittance};
    cases.push_back(make_case("dielectric that passes " + std::to_string(transmittance), m));
  }
  for (const MaterialKind kind :
       {MaterialKind::kConductor, MaterialKind::kDielectric, MaterialKind::kPlastic}) {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
      Material m = material_of(kind, roughness);
      m.microfacets = Microfacets::kBeckmann;
      cases.push_back(make_case("Beckmann kind " + std::to_string(static_cast<int>(kind)) +
                                    " roughness " + std::to_string(roughness),
                                m));
    }
  }
  for (const MaterialKind kind : {MaterialKind::kConductor, MaterialKind::kDielectric}) {
    for (const float anisotropy : {0.3f, 1.0f}) {
      for (const Microfacets microfacets : {Microfacets::kGgx, Microfacets::kBeckmann}) {
        Material m = material_of(kind, 0.3f);
        m.anisotropy.value = anisotropy;
        m.microfacets = microfacets;
        cases.push_back(make_case("brushed kind " + std::to_string(static_cast<int>(kind)) +
                                      " anisotropy " + std::to_string(anisotropy) +
                                      " microfacets " +
                                      std::to_string(static_cast<int>(microfacets)),
                                  m));
      }
    }
  }
  for (BsdfCase& c : principled_cases()) cases.push_back(std::move(c));
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
