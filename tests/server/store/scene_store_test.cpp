#include "server/store/scene_store.h"

#include <gtest/gtest.h>

#include "tests/server/test_service.h"

namespace qray::server {
namespace {

constexpr size_t kPlenty = 1 << 30;  // bytes

class SceneStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { test::write_text(scratch_ / "box/scene.json", test::kBoxScene); }
  qray::test::ScratchFolder scratch_;
};

TEST_F(SceneStoreTest, NamesAreFoldersWithAScene) {
  test::write_text(scratch_ / "empty/readme", "");
  test::write_text(scratch_ / "bad name/scene.json", test::kBoxScene);
  test::write_text(scratch_ / "wrong/scene.json", "{");
  SceneStore store(scratch_.path(), 1, kPlenty);
  EXPECT_TRUE(store.has("box"));
  for (const char* name : {"", "empty", "bad name", "..", "box/", "./box", "nothing"}) {
    EXPECT_FALSE(store.has(name)) << name;
  }
  const std::vector<proto::SceneInfo> list = store.list();
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].name, "box");
  EXPECT_EQ(list[0].width, 48);
  EXPECT_EQ(list[0].height, 40);
  EXPECT_EQ(list[1].name, "wrong");
  EXPECT_EQ(list[1].width, std::nullopt);
}

TEST_F(SceneStoreTest, PreparedScenesAreSharedUntilAFileChanges) {
  SceneStore store(scratch_.path(), 1, kPlenty);
  const auto first = store.prepare("box");
  ASSERT_TRUE(first.ok()) << first.error().text();
  EXPECT_EQ(store.prepare("box").value(), first.value());
  const auto file = scratch_ / "box/scene.json";
  std::filesystem::last_write_time(
      file, std::filesystem::last_write_time(file) + std::chrono::seconds(5));
  const auto second = store.prepare("box");
  EXPECT_NE(second.value(), first.value());
  test::write_text(scratch_ / "box/new.obj", "");
  std::filesystem::last_write_time(
      scratch_ / "box/new.obj", std::filesystem::last_write_time(file) + std::chrono::seconds(5));
  EXPECT_NE(store.prepare("box").value(), second.value());
}

TEST_F(SceneStoreTest, AChangeThatLooksOlderCounts) {
  SceneStore store(scratch_.path(), 1, kPlenty);
  const auto first = store.prepare("box").value();
  const auto file = scratch_ / "box/scene.json";
  std::filesystem::last_write_time(file,
                                   std::filesystem::last_write_time(file) - std::chrono::hours(5));
  EXPECT_NE(store.prepare("box").value(), first);
}

TEST_F(SceneStoreTest, AsManyAreKeptAsMemoryAllows) {
  for (const char* name : {"b", "c"})
    test::write_text(scratch_ / name / "scene.json", test::kBoxScene);
  const size_t each = SceneStore(scratch_.path(), 1, kPlenty).prepare("box").value()->size_bytes();
  EXPECT_GT(each, 1000u);
  SceneStore store(scratch_.path(), 1, 2 * each + each / 2);
  std::weak_ptr<const PreparedScene> a = store.prepare("box").value();
  std::weak_ptr<const PreparedScene> b = store.prepare("b").value();
  ASSERT_TRUE(store.prepare("box").ok());  // used again
  ASSERT_TRUE(store.prepare("c").ok());
  EXPECT_FALSE(a.expired());
  EXPECT_TRUE(b.expired()) << "not used for the longest time";

  SceneStore one(scratch_.path(), 1, 0);
  a = one.prepare("box").value();
  EXPECT_FALSE(a.expired()) << "the newest is kept whatever its size";
}

TEST_F(SceneStoreTest, LoadingCanBeStoppedAndTriedAgain) {
  SceneStore store(scratch_.path(), 1, kPlenty);
  for (const LoadStep stopped_at : {LoadStep::kReading, LoadStep::kBuilding}) {
    const auto stopped =
        store.prepare("box", [&](LoadStep step, double) { return step != stopped_at; });
    ASSERT_FALSE(stopped.ok());
    EXPECT_EQ(stopped.error().code, ErrorCode::kCanceled);
  }
  EXPECT_TRUE(store.prepare("box").ok());
}

TEST_F(SceneStoreTest, ErrorsNameFileAndPlace) {
  test::write_text(scratch_ / "wrong/scene.json",
                   std::string(test::kBoxScene).replace(20, 3, "foo"));
  SceneStore store(scratch_.path(), 1, kPlenty);
  const auto wrong = store.prepare("wrong");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().where.find("scene.json"), std::string::npos) << wrong.error().text();
  EXPECT_EQ(store.prepare("nothing").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace qray::server
