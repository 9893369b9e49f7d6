// What holds a document together: GLB, buffers, URIs, and every index in it.
#include <gtest/gtest.h>

#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::gltf_triangle;
using test::GltfText;

TEST(GltfDocument, GlbAndDataUriAndFileAreTheSameScene) {
  const test::SceneFolder folder;
  const GltfText text = gltf_triangle();
  const auto in_text = folder.load("a.gltf", text.gltf());
  const auto binary = folder.load("a.glb", text.glb());
  std::filesystem::create_directory(folder.path() / "sub dir");
  folder.write("sub dir/b.bin", std::string(text.binary.begin(), text.binary.end()));
  json beside = text.json;
  beside["buffers"] = {{{"byteLength", text.binary.size()}, {"uri", "sub%20dir/b.bin"}}};
  const auto in_file = folder.load("c.gltf", beside.dump());
  for (const auto* loaded : {&in_text, &binary, &in_file}) {
    ASSERT_TRUE(loaded->ok()) << loaded->error().text();
    EXPECT_EQ(loaded->value().hash, in_text.value().hash);
    EXPECT_TRUE(loaded->value().warnings.empty());
  }
  EXPECT_EQ(in_text.value().scene.name, "a");
  EXPECT_EQ(in_text.value().scene.triangle_count(), 1u);
}

TEST(GltfDocument, EveryTruncationOfAGlbIsAnError) {
  const test::SceneFolder folder;
  const std::string whole = gltf_triangle().glb();
  ASSERT_TRUE(folder.load("a.glb", whole).ok());
  for (size_t size = 0; size < whole.size(); ++size) {
    const std::string failure = folder.failure("a.glb", whole.substr(0, size));
    EXPECT_TRUE(failure.starts_with("a.glb:")) << size << ": " << failure;
  }
}

TEST(GltfDocument, GlbHeadersAreChecked) {
  const test::SceneFolder folder;
  const struct {
    size_t offset;
    uint32_t value;
    const char* failure;
  } cases[] = {
      {4, 1, "a.glb:byte 4: expected version 2, got 1"},
      {8, 0x7fffffff, "a.glb:byte 8: expected a file of 2147483647 bytes, got "},
      {8, 0, "a.glb:byte 12: expected a chunk's header and as many bytes as it says"},
      {8, 30, "a.glb:byte 12: expected a chunk's header and as many bytes as it says"},
      {12, 0xffffffff, "a.glb:byte 12: expected a chunk's header and as many bytes as it says"},
      {12, 0, "a.glb:byte 20: expected a chunk's header and as many bytes as it says"},
      {16, 0x004e4942, "a.glb:byte 12: expected a chunk of JSON"},
  };
  for (const auto& c : cases) {
    std::string file = gltf_triangle().glb();
    for (size_t i = 0; i < 4; ++i) file[c.offset + i] = static_cast<char>(c.value >> (8 * i));
    const std::string failure = folder.failure("a.glb", file);
    EXPECT_TRUE(failure.starts_with(c.failure)) << failure;
  }
}

TEST(GltfDocument, FilesLieInTheScenesFolder) {
  const test::SceneFolder folder;
  const GltfText text = gltf_triangle();
  std::filesystem::create_directory(folder.path() / "scene");
  const std::string binary(text.binary.begin(), text.binary.end());
  folder.write("outside.bin", binary);
  std::filesystem::create_symlink(folder.path() / "outside.bin", folder.path() / "scene/link.bin");
  const std::string outside = (folder.path() / "outside.bin").string();
  const std::pair<std::string, std::string> cases[] = {
      {"../outside.bin", "no such file in the scene's folder: \"../outside.bin\""},
      {"%2e%2E/outside.bin", "no such file in the scene's folder: \"../outside.bin\""},
      {outside, "no such file in the scene's folder: \"" + outside + "\""},
      {"link.bin", "no such file in the scene's folder: \"link.bin\""},
      {"gone.bin", "no such file in the scene's folder: \"gone.bin\""},
      {"file:///etc/passwd", "no such file in the scene's folder: \"file:///etc/passwd\""},
      {"http://host/a.bin", "no such file in the scene's folder: \"http://host/a.bin\""},
      {".", "no such file in the scene's folder: \".\""},
      {"", "no such file in the scene's folder: \"\""},
      {"a%00.bin", "expected a file's name without a 0 byte"},
      {"data:application/octet-stream,AAAA", "expected \"data:...;base64,\" and base64"},
      {"data:;base64,AA*A", "expected base64 at character 15"},
  };
  for (const auto& [uri, message] : cases) {
    json document = text.json;
    document["buffers"] = {{{"byteLength", text.binary.size()}, {"uri", uri}}};
    EXPECT_EQ(folder.failure("scene/a.gltf", document.dump()), "a.gltf:/buffers/0/uri: " + message);
    document["buffers"] = {
        {{"byteLength", text.binary.size()}, {"uri", "data:;base64," + test::base64(text.binary)}}};
    document["images"] = {{{"uri", uri}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"][0]["emissiveTexture"] = {{"index", 0}};
    EXPECT_EQ(folder.failure("scene/a.gltf", document.dump()), "a.gltf:/images/0/uri: " + message);
  }
}

TEST(GltfDocument, FaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const struct {
    const char* pointer;  // what is changed, or removed where `value` is discarded
    json value;
    const char* failure;
  } cases[] = {
      {"/asset", json::value_t::discarded, ": \"asset\" is missing"},
      {"/asset/version", "1.0", ":/asset/version: expected a version 2.x, got \"1.0\""},
      {"/extensionsRequired",
       {"KHR_texture_basisu"},
       ":/extensionsRequired/0: the file requires the extension KHR_texture_basisu, which "
       "is not read"},
      {"/scene", 1, ":/scene: expected an integer, 0..0, got 1"},
      {"/scenes/0/nodes/0", 7, ":/scenes/0/nodes/0: expected an integer, 0..0, got 7"},
      {"/scenes/0/nodes/0", -1, ":/scenes/0/nodes/0: expected an integer, 0..0, got -1"},
      {"/scenes/0/nodes/0", 0.5, ":/scenes/0/nodes/0: expected an integer, 0..0, got 0.5"},
      {"/scenes/0/nodes", {0, 0}, ":/nodes/0: expected a node below one other at most, no cycles"},
      {"/nodes/0/children", {0}, ":/nodes/0: expected a node below one other at most, no cycles"},
      {"/nodes/0/children", 0, ":/nodes/0/children: expected an array, got 0"},
      {"/nodes/0/mesh", "0", ":/nodes/0/mesh: expected an integer, 0..0, got \"0\""},
      {"/nodes/0/camera", 0, ":/nodes/0/camera: expected no index, there are no cameras"},
      {"/nodes/0/matrix", {1, 2}, ":/nodes/0/matrix: expected an array of 16 numbers"},
      {"/nodes/0/scale", {1, 1, 1e30}, ":/nodes/0/scale/2: expected -1e+09..1e+09, got 1e+30"},
      {"/nodes/0/rotation", {0, 0, 0, "1"}, ":/nodes/0/rotation/3: expected a number, got \"1\""},
      {"/nodes/0", 5, ":/nodes/0: expected an object, got 5"},
      {"/meshes/0/primitives", json::array(), ":/meshes/0: expected primitives"},
      {"/meshes/0/primitives/0/mode", 7,
       ":/meshes/0/primitives/0/mode: expected an integer, 0..6, got 7"},
      {"/meshes/0/primitives/0/attributes/POSITION", 9,
       ":/meshes/0/primitives/0/attributes/POSITION: expected an integer, 0..0, got 9"},
      {"/meshes/0/primitives/0/attributes", json::object(),
       ":/meshes/0/primitives/0/attributes: expected a POSITION"},
      {"/meshes/0/primitives/0/material", 1,
       ":/meshes/0/primitives/0/material: expected an integer, 0..0, got 1"},
      {"/accessors/0/bufferView", 1, ":/accessors/0/bufferView: expected an integer, 0..0, got 1"},
      {"/accessors/0/byteOffset", -4,
       ":/accessors/0/byteOffset: expected an integer, 0..2147483647, got -4"},
      {"/accessors/0/byteOffset", 4, ":/accessors/0: expected 40 bytes in bufferView 0, got 36"},
      {"/accessors/0/count", 0, ":/accessors/0/count: expected an integer, 1..2147483647, got 0"},
      {"/accessors/0/count", 4, ":/accessors/0: expected 48 bytes in bufferView 0, got 36"},
      {"/accessors/0/count", 2147483647,
       ":/accessors/0: expected 25769803764 bytes in bufferView 0, got 36"},
      {"/accessors/0/count", 1e300,
       ":/accessors/0/count: expected an integer, 1..2147483647, got 1e+300"},
      {"/accessors/0/type", "VEC2", ":/accessors/0/type: expected VEC3, got \"VEC2\""},
      {"/accessors/0/type", "MAT3", ":/accessors/0/type: expected VEC3, got \"MAT3\""},
      {"/accessors/0/type", "VEC5",
       ":/accessors/0/type: expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4, got \"VEC5\""},
      {"/accessors/0/componentType", 5124,
       ":/accessors/0/componentType: expected one of 5120, 5121, 5122, 5123, 5125, 5126, got 5124"},
      {"/bufferViews/0/buffer", 1, ":/bufferViews/0/buffer: expected an integer, 0..0, got 1"},
      {"/bufferViews/0/byteLength", 40,
       ":/bufferViews/0: expected byteOffset and byteLength within the buffer's 36 bytes"},
      {"/bufferViews/0/byteOffset", 2147483647,
       ":/bufferViews/0: expected byteOffset and byteLength within the buffer's 36 bytes"},
      {"/bufferViews/0/byteStride", 2,
       ":/bufferViews/0/byteStride: expected an integer, 4..252, got 2"},
      {"/bufferViews/0/byteStride", 252,
       ":/accessors/0: expected 516 bytes in bufferView 0, got 36"},
      {"/buffers/0/byteLength", 37, ":/buffers/0/byteLength: expected at most 36, got 37"},
      {"/buffers/0/uri", json::value_t::discarded, ":/buffers/0: expected a \"uri\""},
      {"/cameras", 1, ":/cameras: expected an array, got 1"},
  };
  const json good = json::parse(gltf_triangle().gltf());
  ASSERT_EQ(folder.failure("a.gltf", good.dump()), "");
  for (const auto& c : cases) {
    json document = good;
    const json::json_pointer pointer(c.pointer);
    if (c.value.is_discarded())
      document[pointer.parent_pointer()].erase(pointer.back());
    else
      document[pointer] = c.value;
    const std::string failure = folder.failure("a.gltf", document.dump());
    EXPECT_TRUE(failure.starts_with(std::string("a.gltf") + c.failure)) << failure;
  }
}

// Many exporters leave some behind.
TEST(GltfDocument, BrokenPicturesAreErrorsWhereTheyAreUsedAndElseWarnings) {
  const test::SceneFolder folder;
  const json good = json::parse(R"({"textures": [{"source": 0, "sampler": 0}],
    "images": [{"uri": "p.png"}], "samplers": [{}]})");
  folder.write("p.png", "not read here");
  const struct {
    const char* pointer;
    json value;  // discarded: removed
    std::string fault;
  } cases[] = {
      {"/images", json::value_t::discarded,
       "a.gltf:/textures/0/source: expected no index, there are no images"},
      {"/textures/0/source", 4, "a.gltf:/textures/0/source: expected an integer, 0..0, got 4"},
      {"/textures/0/sampler", "x",
       "a.gltf:/textures/0/sampler: expected an integer, 0..0, got \"x\""},
      {"/samplers/0/wrapS", 1,
       "a.gltf:/samplers/0/wrapS: expected one of 10497, 33071, 33648, got 1"},
      {"/images/0",
       {{"bufferView", 1}},
       "a.gltf:/images/0/bufferView: expected an integer, 0..0, got 1"},
  };
  for (const auto& c : cases) {
    GltfText text = gltf_triangle();
    json parts = good;
    const json::json_pointer pointer(c.pointer);
    if (c.value.is_discarded())
      parts.erase("images");
    else
      parts[pointer] = c.value;
    text.json.update(parts);
    const LoadedScene unused = test::load_gltf(folder, text);
    EXPECT_EQ(unused.warnings, std::vector<std::string>{c.fault + "; nothing drawn uses it"});
    text.json["materials"][0]["emissiveTexture"] = {{"index", 0}};
    EXPECT_EQ(folder.failure("a.gltf", text.gltf()), c.fault);
  }
}

TEST(GltfDocument, CountsAreLimitedBeforeMemoryIsTaken) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["accessors"][0].erase("bufferView");  // of zeros, as many as you like
  text.json["accessors"][0]["count"] = 2147483647;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/meshes/0/primitives/0: expected at most 5000000 triangles");
  // Of two thousand million vertices three are wanted.
  text.primitive()["indices"] = text.add_indices({0, 1, 65535});
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/meshes: expected at least one shape with an area");
}

TEST(GltfDocument, HostileJsonIsAnError) {
  const test::SceneFolder folder;
  const std::string deep(100'000, '[');
  EXPECT_NE(folder.failure("a.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"extras\": " + deep)
                .find("nested too deeply"),
            std::string::npos);
  EXPECT_EQ(folder.failure("a.gltf", "[]"), "a.gltf: expected an object, got an array of 0");
  EXPECT_EQ(folder.failure("a.gltf", R"({"asset": 1, "asset": 2})"),
            "a.gltf:/asset: appears twice");
  std::string nodes = "{},";
  for (int i = 0; i < 17; ++i) nodes += nodes;  // 2^17
  EXPECT_EQ(folder.failure("a.gltf",
                           R"({"asset": {"version": "2.0"}, "nodes": [)" + nodes + nodes + "{}]}"),
            "a.gltf:/nodes: expected at most 250000");
  std::string values = "0,";
  for (int i = 0; i < 22; ++i) values += values;  // 2^22
  EXPECT_EQ(
      folder.failure("a.gltf", R"({"asset": {"version": "2.0"}, "extras": [)" + values + "0]}"),
      "a.gltf: has too many values");
}

}  // namespace
}  // namespace qray
