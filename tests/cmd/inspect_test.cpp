// diff, table and scene check: what the command tells of files.
#include <nlohmann/json.hpp>

#include "core/base/file.h"
#include "core/guide/table_file.h"
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

class TableCommands : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (scratch_ / name).string(); }
  // A small table of cornell-box.
  std::string learned(const std::string& name, const std::string& method, const char* seed) const {
    const Outcome done =
        qray_command({"render", "cornell-box", "--size", "24x16", "--spp", "16", "--method", method,
                      "--seed", seed, "-q", "--table-out", file(name), "-o", file("x.exr")});
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    return file(name);
  }
  nlohmann::json info(const std::string& path) const {
    const Outcome told = qray_command({"table", "info", path, "--json"});
    EXPECT_EQ(told.code, cmd::kExitOk) << told.err;
    return nlohmann::json::parse(told.out, nullptr, false);
  }
  static void expect_refusal(const std::vector<std::string>& arguments, const std::string& says) {
    const Outcome told = qray_command(arguments);
    EXPECT_EQ(told.code, cmd::kExitBadInput) << told.out;
    EXPECT_NE(told.err.find(says), std::string::npos) << told.err;
  }
  ScratchFolder scratch_;
};

TEST_F(TableCommands, MergeGivesOneTableInEitherOrder) {
  const std::string a = learned("a.qrt", "huang", "1"), b = learned("b.qrt", "huang", "2");
  ASSERT_EQ(qray_command({"table", "merge", a, b, "-o", file("ab.qrt")}).code, cmd::kExitOk);
  ASSERT_EQ(qray_command({"table", "merge", b, a, "-o", file("ba.qrt")}).code, cmd::kExitOk);
  EXPECT_EQ(read_file(file("ab.qrt"), 1 << 26).value(), read_file(file("ba.qrt"), 1 << 26).value());
  const nlohmann::json of_a = info(a), of_b = info(b), merged = info(file("ab.qrt"));
  EXPECT_EQ(merged["samples_seen"],
            of_a["samples_seen"].get<int>() + of_b["samples_seen"].get<int>());
  EXPECT_EQ(merged["parents"].size(), 2u);
  EXPECT_GE(merged["states"], of_a["states"]);
  EXPECT_LT(merged["states"], of_a["states"].get<int>() + of_b["states"].get<int>());
  const Outcome good = qray_command({"table", "verify", file("ab.qrt"), "--scene", "cornell-box"});
  EXPECT_EQ(good.code, cmd::kExitOk) << good.err;
  EXPECT_NE(good.out.find(": good"), std::string::npos) << good.out;
  const Outcome used =
      qray_command({"render", "cornell-box", "--size", "24x16", "--spp", "4", "-q", "--table-in",
                    file("ab.qrt"), "--table-out", file("y.qrt"), "-o", file("y.exr")});
  EXPECT_EQ(used.code, cmd::kExitOk) << used.err;
  EXPECT_EQ(info(file("y.qrt"))["method"], "huang");  // the table's own
}

TEST_F(TableCommands, MergeRefusesWhatDoesNotBelongTogether) {
  const std::string a = learned("a.qrt", "huang", "1"), b = learned("b.qrt", "ppg", "2"),
                    c = learned("c.qrt", "ppg", "3"), out = file("out.qrt");
  expect_refusal({"table", "merge", a, b, "-o", out}, "differs from table");
  expect_refusal({"table", "merge", b, c, "-o", out}, "'ppg' cannot be merged");
  expect_refusal({"table", "merge", a, a, "-o", out}, "twice");
  expect_refusal({"table", "merge", a, "-o", out}, "files");
  expect_refusal({"table", "merge", a, file("none.qrt"), "-o", out}, "none.qrt");
  expect_refusal({"table", "merge", a, b, "-o", file("no/out.qrt")}, "no such folder");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(TableCommands, VerifyNamesTheFaultAndThePlace) {
  const std::string path = learned("a.qrt", "huang", "1");
  expect_refusal({"table", "verify", path, "--scene", "ajar-door"},
                 "a.qrt:table: the table was learned from another scene, whose geometry");
  Bytes bytes = read_file(path, 1 << 26).value();
  const TableFile good = decode_table(bytes).value();
  bytes[bytes.size() - 3] ^= 1;
  ASSERT_TRUE(write_file_atomic(path, bytes).ok());
  expect_refusal({"table", "verify", path}, "the checksum of section 1 is wrong");
  TableFile bad = good;
  bad.header.samples_seen += 7;
  ASSERT_TRUE(write_file_atomic(path, encode_table(bad)).ok());
  expect_refusal({"table", "verify", path}, "a.qrt:table, header: the id is");
  bad = good;
  bad.sections[1].bytes[8 + 8 + 3] = 0xff;  // a negative value
  bad.header.id = table_id(bad);
  ASSERT_TRUE(write_file_atomic(path, encode_table(bad)).ok());
  expect_refusal({"table", "verify", path}, "a.qrt:table:HQ26, state 0: expected rising keys");
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
