#include "core/import/scene_entry.h"

#include <gtest/gtest.h>

#include <vector>

namespace qray {
namespace {

using Names = std::vector<std::string>;

TEST(SceneEntry, IsTheNearestToTheTopOfTheLikeliestKind) {
  const std::pair<Names, const char*> cases[] = {
      {{"a.obj", "a.mtl"}, "a.obj"},
      {{"a.ply", "scene.json", "b.ply"}, "scene.json"},
      {{"room/room.gltf", "room/room.bin", "room/parts/a.glb"}, "room/room.gltf"},
      {{"meshes/a.ply", "meshes/b.ply", "scene.xml"}, "scene.xml"},
      {{"a.obj", "b.glb", "c.ply"}, "b.glb"},
      {{"deep/scene.json", "a.ply"}, "a.ply"},
      {{"__MACOSX/._a.gltf", "in/a.gltf"}, "in/a.gltf"},
  };
  for (const auto& [names, entry] : cases) {
    const Result<std::string> found = find_scene_entry(names);
    ASSERT_TRUE(found.ok()) << found.error().text();
    EXPECT_EQ(found.value(), entry);
  }
}

TEST(SceneEntry, NoneOrSeveralAreErrors) {
  EXPECT_EQ(find_scene_entry(Names{}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(find_scene_entry(Names{"a.json", "b.png"}).error().code, ErrorCode::kNotFound);
  const Error two = find_scene_entry(Names{"a.gltf", "b.glb", "c.ply"}).error();
  EXPECT_EQ(two.code, ErrorCode::kInvalid);
  EXPECT_NE(two.message.find("\"a.gltf\" and \"b.glb\""), std::string::npos) << two.message;
}

}  // namespace
}  // namespace qray
