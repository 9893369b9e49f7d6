// Files with bytes changed at random load or fail, and do nothing else. The sanitizer build runs
// this too.
#include <gtest/gtest.h>

#include "tests/core/import/gltf_text.h"
#include "tests/support/random.h"

namespace qray {
namespace {

using nlohmann::json;
using test::GltfText;

// A little of everything that is read.
GltfText rich_document() {
  GltfText text = test::gltf_triangle();
  json& d = text.json;
  auto& attributes = text.primitive()["attributes"];
  attributes["NORMAL"] = text.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  attributes["TEXCOORD_0"] = text.add_floats({0, 0, 1, 0, 0, 1}, "VEC2");
  attributes["COLOR_0"] = text.add_floats({1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1}, "VEC4");
  text.primitive()["indices"] = text.add_indices({0, 1, 2, 1});
  text.primitive()["mode"] = 5;
  const Bytes sparse = {1, 2};
  d["accessors"][1]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", text.add_view(sparse)}, {"componentType", 5121}}},
      {"values", {{"bufferView", 0}}}};
  d["images"] = {{{"bufferView", text.add_view(sparse)}}};
  d["samplers"] = {{{"wrapS", 33071}}};
  d["textures"] = {{{"source", 0}, {"sampler", 0}}};
  d["materials"] = {json::parse(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
    "texCoord": 0, "extensions": {"KHR_texture_transform": {"rotation": 1, "scale": [2, 2]}}},
    "metallicFactor": 0.5}, "alphaMode": "MASK", "emissiveFactor": [1, 1, 1],
    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5},
      "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
      "KHR_materials_ior": {"ior": 1.4}}})")};
  d["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"aspectRatio", 2}}}}};
  d["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", json::object()}}};
  d["nodes"] = {{{"mesh", 0}, {"children", {1, 2}}, {"rotation", {0, 0, 0, 1}}},
                {{"camera", 0}, {"translation", {0, 0, 3}}},
                {{"mesh", 0}}};
  d["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  d["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 0;
  return text;
}

class GltfMutation : public testing::TestWithParam<const char*> {};

TEST_P(GltfMutation, LoadsOrNamesTheFile) {
  const test::SceneFolder folder;
  const std::string name = GetParam();
  const std::string good = name.ends_with(".glb") ? rich_document().glb() : rich_document().gltf();
  ASSERT_EQ(folder.failure(name, good), "");
  test::Random rng(7);
  int loaded_count = 0;
  constexpr int kRuns = 1500;
  for (int run = 0; run < kRuns; ++run) {
    std::string text = good;
    const uint32_t changes = 1 + rng.next_u32() % 3;
    for (uint32_t i = 0; i < changes; ++i) {
      const size_t at = rng.next_u32() % text.size();
      switch (rng.next_u32() % 4) {
        case 0:
          text[at] = static_cast<char>(rng.next_u32());
          break;
        case 1:
          text[at] = "0123456789-{}[],\""[rng.next_u32() % 17];
          break;
        case 2:
          text.erase(at, 1 + rng.next_u32() % 4);
          break;
        default:
          text.insert(at, 1, "0123456789.e-"[rng.next_u32() % 13]);
      }
    }
    const auto loaded = folder.load(name, text);
    if (loaded.ok())
      ++loaded_count;
    else
      EXPECT_TRUE(loaded.error().text().starts_with(name)) << loaded.error().text();
  }
  EXPECT_GT(loaded_count, kRuns / 100);
  EXPECT_LT(loaded_count, kRuns);
}

INSTANTIATE_TEST_SUITE_P(All, GltfMutation, testing::Values("a.gltf", "a.glb"));

}  // namespace
}  // namespace qray
