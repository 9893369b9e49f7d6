// What a job's table knows, as pictures over HTTP.
#include <gtest/gtest.h>

#include "tests/server/pictures.h"

namespace qray::server {
namespace {

using test::Json;
using test::same_bits;
using test::TestService;

const Json kTinySeen = {
    {"scene", "box"}, {"width", 32}, {"height", 24}, {"samples", 64}, {"learning_samples", 16}};

Json tiny_seen(const Json& changes) {
  Json request = kTinySeen;
  request.update(changes);
  return request;
}

class ServiceViewsTest : public ::testing::Test {
 protected:
  void SetUp() override { s_.start(); }
  std::string ended(const Json& request) const {
    const std::string id = s_.submit(request);
    s_.wait_end(id);
    return "/v1/jobs/" + id;
  }
  Image png(const std::string& path) const {
    test::PictureAnswer answer = test::get_picture(s_, path);
    EXPECT_FALSE(answer.metadata["scale"].empty()) << path;
    return std::move(answer.image);
  }

  TestService s_;
};

TEST_F(ServiceViewsTest, ShowWhatTheJobsTableKnows) {
  for (const char* method : {"huang", "ppg"}) {
    const std::string job = ended(tiny_seen({{"method", method}}));
    std::vector<Image> views;
    for (const char* name : {"state", "beta", "gain"}) {
      views.push_back(png(job + "/view.png?view=" + name));
      EXPECT_EQ(views.back().width(), 32);
      EXPECT_EQ(views.back().height(), 24);
    }
    EXPECT_FALSE(same_bits(views[0], views[1])) << method;
    EXPECT_FALSE(same_bits(views[1], views[2])) << method;
    const Image floor = png(job + "/lobe.png?x=16&y=18"), wall = png(job + "/lobe.png?x=16&y=8");
    EXPECT_EQ(floor.height(), wall.height());
    EXPECT_FALSE(same_bits(floor, wall)) << method;
  }
}

TEST_F(ServiceViewsTest, AreNoLargerThanNeeded) {
  const std::string job = ended(tiny_seen({{"width", 720}, {"height", 180}, {"samples", 4}}));
  const Image view = png(job + "/view.png?view=state");
  EXPECT_EQ(view.width(), 512);
  EXPECT_EQ(view.height(), 128);
  png(job + "/lobe.png?x=360&y=144");  // a pixel of the job's picture, not of the view's
}

TEST_F(ServiceViewsTest, SayWhatIsWrongWithTheRequest) {
  const std::string job = ended(kTinySeen);
  const auto expect_pointer = [&](const std::string& path, const char* pointer) {
    const Json problem = s_.get(job + path, 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], pointer) << path << problem.dump();
  };
  expect_pointer("/view.png", "/view");
  expect_pointer("/view.png?view=albedo", "/view");
  expect_pointer("/view.png?view=lobe", "/view");
  expect_pointer("/lobe.png", "/x");
  expect_pointer("/lobe.png?x=1", "/y");
  expect_pointer("/lobe.png?x=32&y=1", "/x");
  expect_pointer("/lobe.png?x=-1&y=1", "/x");
  expect_pointer("/lobe.png?x=1.5&y=1", "/x");
  expect_pointer("/lobe.png?x=1&y=24", "/y");
  expect_pointer("/lobe.png?x=0&y=0", "/x");  // past the box: no surface
  for (const char* path : {"/v1/jobs/j000099/view.png?view=beta", "/v1/jobs/x/lobe.png?x=1&y=1"})
    s_.get(path, 404);
}

TEST_F(ServiceViewsTest, NeedATable) {
  const std::string plain = ended(tiny_seen({{"method", "none"}}));
  const std::string running = s_.submit(tiny_seen({{"samples", 1'000'000}}));
  for (const std::string& job : {plain, "/v1/jobs/" + s_.submit(kTinySeen)})  // it waits
    for (const char* path : {"/view.png?view=beta", "/lobe.png?x=16&y=18"})
      EXPECT_EQ(s_.get(job + path, 409)["detail"], "no table of this job is kept") << job;
  s_.post("/v1/jobs/" + running + "/cancel", "", 202);
  // A table that no other job gets is one still.
  EXPECT_EQ(png(ended(tiny_seen({{"table", "none"}})) + "/view.png?view=beta").width(), 32);
}

TEST_F(ServiceViewsTest, NeedTheTableAndTheSceneAsTheyWere) {
  const std::string job = ended(kTinySeen);
  const auto detail = [&] {
    return s_.get(job + "/view.png?view=gain", 409)["detail"].get<std::string>();
  };
  std::string text = test::kBoxScene;
  text.replace(text.find("[10, 9, 8]"), 10, "[10, 9, 7]");
  test::write_text(s_.config.scenes / "box/scene.json", text);
  EXPECT_NE(detail().find("scene has changed"), std::string::npos);
  test::write_text(s_.config.scenes / "box/scene.json", test::kBoxScene);
  for (const auto& entry : std::filesystem::directory_iterator(s_.config.data / "tables"))
    std::filesystem::remove(entry);
  EXPECT_NE(detail().find("cannot be read"), std::string::npos);
  EXPECT_EQ(detail().find(s_.scratch.path().string()), std::string::npos);
  std::filesystem::remove_all(s_.config.scenes / "box");
  EXPECT_NE(detail().find("scene cannot be loaded"), std::string::npos);
}

}  // namespace
}  // namespace qray::server
