// diff, table info and scene check: what the command tells of files.
#include <nlohmann/json.hpp>

#include "core/base/file.h"
#include "core/image/image_io.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

Image plain(float value, int width = 16) {
  Image image(width, 12, 3);
  std::fill(image.data().begin(), image.data().end(), value);
  return image;
}

class DiffCommand : public ::testing::Test {
 protected:
  std::string write(const char* name, const Image& image) const {
    const std::string path = (scratch_ / name).string();
    EXPECT_TRUE(write_image(path, image).ok());
    return path;
  }
  ScratchFolder scratch_;
};

TEST_F(DiffCommand, ComparesWithTheReference) {
  const std::string a = write("a.exr", plain(0.6f)), b = write("b.exr", plain(0.5f));
  const Outcome told = qray_command({"diff", a, b, "--json"});
  ASSERT_EQ(told.code, cmd::kExitOk) << told.err;
  const nlohmann::json d = nlohmann::json::parse(told.out, nullptr, false);
  EXPECT_NEAR(d["relmse"].get<double>(), 0.01 / 0.26, 1e-5);
  EXPECT_NEAR(d["mean_ratio"].get<double>(), 1.2, 1e-5);
  EXPECT_NEAR(d["max_abs"].get<double>(), 0.1, 1e-5);
  EXPECT_TRUE(d.contains("relmse_trimmed"));
  EXPECT_GT(d["flip"].get<double>(), 0);
  EXPECT_NE(qray_command({"diff", a, b}).out.find("mean_ratio"), std::string::npos);
}

TEST_F(DiffCommand, ReadsDisplayPicturesAsLight) {
  const Image grey = plain(0.25f);
  const Outcome told = qray_command({"diff", write("a.png", grey), write("b.exr", grey), "--json"});
  ASSERT_EQ(told.code, cmd::kExitOk) << told.err;
  const nlohmann::json d = nlohmann::json::parse(told.out, nullptr, false);
  EXPECT_LT(d["max_abs"].get<double>(), 0.002);  // half a step of 8 bits
}

TEST_F(DiffCommand, RefusesWhatCannotBeCompared) {
  const std::string a = write("a.exr", plain(1)), b = write("b.exr", plain(1, 17));
  EXPECT_EQ(qray_command({"diff", a, b}).code, cmd::kExitBadInput);
  const Outcome missing = qray_command({"diff", a, (scratch_ / "none.exr").string()});
  EXPECT_EQ(missing.code, cmd::kExitBadInput);
  EXPECT_NE(missing.err.find("none.exr"), std::string::npos) << missing.err;
}

TEST(TableCommand, NamesADamagedFile) {
  const ScratchFolder scratch;
  const std::string path = (scratch / "bad.qrt").string();
  const Bytes bytes(100, 7);
  ASSERT_TRUE(write_file_atomic(path, bytes).ok());
  const Outcome told = qray_command({"table", "info", path});
  EXPECT_EQ(told.code, cmd::kExitBadInput);
  EXPECT_NE(told.err.find("bad.qrt"), std::string::npos) << told.err;
}

TEST(SceneCommand, CountsAGoodScene) {
  const Outcome told = qray_command({"scene", "check", "cornell-box"});
  EXPECT_EQ(told.code, cmd::kExitOk) << told.err;
  EXPECT_NE(told.out.find(": good"), std::string::npos) << told.out;
  EXPECT_NE(told.out.find("emitting triangles"), std::string::npos) << told.out;
}

TEST(SceneCommand, TellsThePlaceOfAFault) {
  const ScratchFolder scratch;
  const std::string path = (scratch / "scene.json").string();
  const std::string text = R"({"materials": 5})";
  ASSERT_TRUE(
      write_file_atomic(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()}).ok());
  const Outcome told = qray_command({"scene", "check", path});
  EXPECT_EQ(told.code, cmd::kExitBadInput);
  EXPECT_NE(told.err.find("scene.json"), std::string::npos) << told.err;
}

}  // namespace
}  // namespace qray::test
