// A guide serves a layered surface nearly as well as a Lambert one: the room behind a door ajar,
// with its diffuse materials written in other words.
#include <gtest/gtest.h>

#include "core/import/load_scene.h"
#include "tests/support/places.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

std::shared_ptr<const PreparedScene> door_ajar(MaterialKind kind, float roughness) {
  Scene scene = load_scene(test::source_dir() / "scenes/ajar-door/scene.json").value().scene;
  for (Material& material : scene.materials) {
    if (material.kind != MaterialKind::kDiffuse) continue;
    material.kind = kind;
    material.roughness.value = roughness;
  }
  return test::prepare(std::move(scene));
}

// relMSE without its outliers, times rays; guides start from what the truth left.
double price(const PreparedScene& scene, const std::string& method, const test::Rendered& truth) {
  test::Moments prices;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    RenderSettings settings = test::small_settings(method, truth.image.width(), 32, seed);
    settings.gate = false;
    const test::Rendered rendered = test::render(
        scene, settings, method == "none" ? std::optional<TableFile>() : truth.job.table);
    prices.add(image_difference(rendered.image, truth.image).value().relmse_trimmed *
               static_cast<double>(rendered.job.stats.rays));
  }
  return prices.mean();
}

TEST(EverySurface, GainsByTheGuide) {
  const std::pair<MaterialKind, float> cases[] = {{MaterialKind::kDiffuse, 0},
                                                  {MaterialKind::kPlastic, 0.6f},
                                                  {MaterialKind::kPrincipled, 0.8f}};
  for (const auto& [kind, roughness] : cases) {
    const auto scene = door_ajar(kind, roughness);
    RenderSettings settings = test::small_settings("adaptive", 48, 512, 99);
    settings.gate = false;
    const test::Rendered truth = test::render(*scene, settings);
    const double gain = price(*scene, "none", truth) / price(*scene, "adaptive", truth);
    EXPECT_GT(gain, 2) << static_cast<int>(kind);
  }
}

}  // namespace
}  // namespace qray
