#include "core/import/ply.h"

#include <gtest/gtest.h>

#include <bit>

#include "core/import/import_failure.h"
#include "tests/core/import/scene_text.h"

namespace qray {
namespace {

std::string header(const std::string& format, int vertices, int faces,
                   const std::string& vertex_properties = "") {
  return "ply\nformat " + format + " 1.0\ncomment a test\nelement vertex " +
         std::to_string(vertices) + "\nproperty float x\nproperty float y\nproperty float z\n" +
         vertex_properties + "element face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}
const std::string kCorners = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

class BinaryBody {
 public:
  explicit BinaryBody(bool big_endian) : big_endian_(big_endian) {}
  template <class T>
  BinaryBody& add(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big_endian_) std::reverse(bytes.begin(), bytes.end());
    text_.append(bytes.data(), bytes.size());
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  bool big_endian_;
  std::string text_;
};

std::string binary_quad(bool big_endian) {
  BinaryBody body(big_endian);
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}})
    body.add(p.x).add(p.y).add(p.z).add(double{2}).add(uint8_t{7});
  body.add(uint8_t{4}).add(int32_t{0}).add(int32_t{1}).add(int32_t{2}).add(int32_t{3});
  return header(big_endian ? "binary_big_endian" : "binary_little_endian", 4, 1,
                "property double quality\nproperty uint8 flag\n") +
         body.text();
}

TEST(Ply, AllFormatsReadTheSame) {
  const test::SceneFolder folder;
  const Mesh ascii =
      read_ply(folder.write("a.ply", header("ascii", 4, 1) + kCorners + "4 0 1 2 3\n"), {});
  EXPECT_EQ(ascii.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(ascii.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  for (const bool big_endian : {false, true}) {
    const Mesh binary = read_ply(folder.write("b.ply", binary_quad(big_endian)), {});
    EXPECT_EQ(binary.positions, ascii.positions);
    EXPECT_EQ(binary.triangles, ascii.triangles);
  }
}

TEST(Ply, ReadsNormalsAndCoordinatesUnderEitherName) {
  const test::SceneFolder folder;
  for (const std::string names :
       {"property float s\nproperty float t\n", "property float u\nproperty float v\n"}) {
    const Mesh mesh = read_ply(
        folder.write("a.ply",
                     header("ascii", 3, 1,
                            "property float nx\nproperty float ny\nproperty float nz\n" + names) +
                         "0 0 0 0 0 2 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 0.5\n3 0 1 2"),
        {});
    EXPECT_EQ(mesh.normals, (std::vector<Vec3>(3, {0, 0, 1})));
    EXPECT_EQ(mesh.uvs, (std::vector<Vec2>{{0, 0}, {1, 0}, {0, 0.5f}}));
  }
}

TEST(Ply, ColorsAreOfBytesOrOfNumbers) {
  const test::SceneFolder folder;
  const auto colors = [&folder](const std::string& type, const std::string& values) {
    const std::string rgb =
        "property " + type + " red\nproperty " + type + " green\nproperty " + type + " blue\n";
    return read_ply(folder.write("a.ply", header("ascii", 3, 1, rgb) + "0 0 0 " + values +
                                              "\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2"),
                    {})
        .colors;
  };
  const std::vector<Rgb> bytes = colors("uchar", "255 128 0"), numbers = colors("float", "1 .5 0");
  ASSERT_EQ(bytes.size(), 3u);
  EXPECT_NEAR(bytes[0].r, 1, 1e-6f);
  EXPECT_NEAR(bytes[0].g, 0.2158f, 1e-4f);  // display-encoded
  EXPECT_EQ(numbers.at(0), (Rgb{1, 0.5f, 0}));
}

TEST(Ply, ConcaveFacesKeepTheirShapeAndEdgesAreNoFaces) {
  const test::SceneFolder folder;
  const Mesh mesh =
      read_ply(folder.write("a.ply", header("ascii", 4, 2) + "0 0 0\n4 0 0\n1 1 0\n0 4 0\n"
                                                             "4 1 2 3 0\n2 0 1\n"),
               {});
  float area = 0;
  for (const auto& t : mesh.triangles) {
    const float twice = cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                              mesh.positions[t[2]] - mesh.positions[t[0]])
                            .z;
    EXPECT_GT(twice, 0);
    area += 0.5f * twice;
  }
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_NEAR(area, 4, 1e-5f);
}

TEST(Ply, LoadsAsAGreyMeshUnderASky) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.ply", header("ascii", 4, 1) + kCorners + "4 0 1 2 3\n");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.environment.radiance, Rgb{1});
  EXPECT_EQ(loaded.value().scene.name, "a");
}

TEST(Ply, NamesTheLineOrByteOfEveryFault) {
  const std::string little = binary_quad(false);
  const std::string start = "ply\nformat ascii 1.0\n";
  const struct {
    std::string text;
    std::string error;
  } cases[] = {
      {"", "a.ply:1: the header has no \"end_header\" line"},
      {"plan\n", "a.ply:1: expected \"ply\""},
      {"ply\nformat ascii 2.0\n", "a.ply:2: expected \"format KIND 1.0\""},
      {"ply\nformat utf8 1.0\n", "a.ply:2: expected ascii, binary_little_endian or"},
      {"ply\nend_header\n", "a.ply:2: expected a \"format\" line"},
      {start + "element vertex\n", "a.ply:3: expected \"element NAME COUNT\""},
      {start + "element vertex -3\n", "a.ply:3: expected a count"},
      {start + "property float x\n", "a.ply:3: expected an element before its properties"},
      {start + "element vertex 3\nproperty real x\n", "a.ply:4: expected a type such as float"},
      {start + "element face 3\nproperty list float int i\n", "a.ply:4: expected an integer type"},
      {start + "elephant\n", "a.ply:3: expected format, element, property or end_header"},
      {start + "element vertex 1\nproperty float x\nend_header\n0\n",
       "a.ply: expected vertex properties x, y and z"},
      {header("ascii", 4, 1), "a.ply: has 0 bytes left, too few for 4 of \"vertex\""},
      {header("ascii", 2'000'000'000, 1) + kCorners,
       "a.ply: has 24 bytes left, too few for 2000000000 of \"vertex\""},
      {header("binary_little_endian", 2, 0) + "12 bytes....",
       "a.ply: has 12 bytes left, too few for 2 of \"vertex\""},
      {header("ascii", 4, 1) + "0 0 0\n1 0 zero\n1 1 0\n0 1 0\n4 0 1 2 3\n",
       "a.ply:12: expected a number, got \"zero\""},
      {header("ascii", 4, 1) + "0 0 0\n1 0 nan\n1 1 0\n0 1 0\n4 0 1 2 3\n",
       "a.ply:12: expected a finite position"},
      {header("ascii", 4, 1) + kCorners + "4 0 1 2 4\n",
       "a.ply:15: expected a vertex index below 4"},
      {header("ascii", 4, 1) + kCorners + "4 0 1 -2 3\n",
       "a.ply:15: expected a vertex index below 4"},
      {header("ascii", 4, 1) + kCorners + "2000 0 1\n", "a.ply:15: expected at most 1024 corners"},
      {header("ascii", 4, 1) + kCorners + "4 0 1 2\n", "a.ply:16: the file ends too early"},
      {little.substr(0, little.size() - 3),
       "a.ply at byte " + std::to_string(little.size() - 4) + ": the file ends too early"},
      {start + "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
               "end_header\n",
       "a.ply: expected elements \"vertex\" and \"face\""},
  };
  const test::SceneFolder folder;
  for (const auto& c : cases) {
    const std::string failure = folder.failure("a.ply", c.text);
    EXPECT_EQ(failure.substr(0, c.error.size()), c.error) << c.text;
  }
}

TEST(Ply, EveryTruncationIsAnError) {
  const test::SceneFolder folder;
  for (const std::string& whole :
       {binary_quad(true), header("ascii", 4, 1) + kCorners + "4 0 1 2 3"}) {
    for (size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(folder.failure("a.ply", whole.substr(0, size)), "") << size;
  }
}

}  // namespace
}  // namespace qray
