#include "core/import/serialized.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>

#include "core/import/import_failure.h"
#include "tests/core/import/mitsuba_text.h"

namespace qray {
namespace {

template <class T>
void put(Bytes& out, T value) {
  const auto* p = reinterpret_cast<const uint8_t*>(&value);
  out.insert(out.end(), p, p + sizeof value);
}

struct ShapeOptions {
  uint16_t version = 4;
  uint32_t flags = 0x1000;
  uint64_t vertices = 3, triangles = 1;  // as claimed
  uint32_t last_index = 2;
};

// A triangle of z = `z`, as one shape of a file.
template <class Number>
Bytes shape(const ShapeOptions& o, Number z) {
  Bytes body;
  put(body, o.flags);
  if (o.version >= 4)
    for (const char c : std::string("a name\0", 7)) put(body, c);
  put(body, o.vertices);
  put(body, o.triangles);
  for (const Number v : {Number(0), Number(0), z, Number(1), Number(0), z, Number(0), Number(1), z})
    put(body, v);
  if (o.flags & 1)
    for (int i = 0; i < 9; ++i) put(body, Number(i % 3 == 2 ? 5 : 0));
  if (o.flags & 2)
    for (int i = 0; i < 6; ++i) put(body, Number(i));
  for (const uint32_t i : {0u, 1u, o.last_index}) put(body, i);
  uLongf size = compressBound(body.size());
  Bytes deflated(size);
  compress(deflated.data(), &size, body.data(), body.size());
  deflated.resize(size);
  Bytes out;
  put(out, uint16_t{0x041C});
  put(out, o.version);
  out.insert(out.end(), deflated.begin(), deflated.end());
  return out;
}

Bytes file_of(const std::vector<Bytes>& shapes, uint16_t version) {
  Bytes out;
  std::vector<uint64_t> offsets;
  for (const Bytes& s : shapes) {
    offsets.push_back(out.size());
    out.insert(out.end(), s.begin(), s.end());
  }
  for (const uint64_t offset : offsets) {
    if (version >= 4)
      put(out, offset);
    else
      put(out, static_cast<uint32_t>(offset));
  }
  put(out, static_cast<uint32_t>(shapes.size()));
  return out;
}

std::string failure(const Bytes& bytes, size_t index = 0) {
  try {
    read_serialized(bytes, index, {}, "a.serialized");
  } catch (const ImportFailure& e) {
    return e.error.text();
  }
  return "";
}

TEST(Serialized, BothVersionsAndPrecisionsGiveEachShape) {
  for (const uint16_t version : {uint16_t{3}, uint16_t{4}}) {
    ShapeOptions plain{.version = version};
    ShapeOptions full{.version = version, .flags = 0x2000 | 1 | 2 | 0x10};
    const Bytes bytes = file_of({shape<float>(plain, 1), shape<double>(full, 2)}, version);
    const SerializedShape a = read_serialized(bytes, 0, {}, "a.serialized");
    EXPECT_EQ(a.mesh.positions, (std::vector<Vec3>{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}));
    EXPECT_EQ(a.mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}}));
    EXPECT_TRUE(a.mesh.normals.empty());
    EXPECT_FALSE(a.face_normals);
    const SerializedShape b = read_serialized(bytes, 1, {}, "a.serialized");
    EXPECT_EQ(b.mesh.positions[1], (Vec3{1, 0, 2}));
    EXPECT_EQ(b.mesh.normals, (std::vector<Vec3>(3, Vec3{0, 0, 1})));
    EXPECT_EQ(b.mesh.uvs, (std::vector<Vec2>{{0, 1}, {2, 3}, {4, 5}}));
    EXPECT_TRUE(b.face_normals);
  }
}

TEST(Serialized, LiesAreRefusedBeforeMemoryIsTaken) {
  const auto lie = [](const ShapeOptions& o) { return failure(shape<float>(o, 0)); };
  EXPECT_EQ(failure({}), "a.serialized at byte 0: the file ends too early");
  EXPECT_EQ(failure({1, 2, 3, 4}), "a.serialized at byte 0: expected a Mitsuba .serialized file");
  EXPECT_EQ(lie({.version = 7}), "a.serialized at byte 2: expected version 3 or 4, got 7");
  EXPECT_NE(lie({.vertices = 1u << 22}).find("is too short for the 4194304"), std::string::npos);
  EXPECT_NE(lie({.triangles = 1u << 22}).find("is too short"), std::string::npos);
  EXPECT_NE(lie({.triangles = ~uint64_t{0}}).find("expected at most 5000000"), std::string::npos);
  EXPECT_NE(lie({.vertices = 4}).find("expected"), std::string::npos);
  EXPECT_NE(lie({.last_index = 3}).find("expected vertex indices below 3, got 3"),
            std::string::npos);
  const Bytes good = file_of({shape<float>({}, 1)}, 4);
  EXPECT_NE(failure(good, 1).find("has 1 shapes, none of index 1"), std::string::npos);
  Bytes wild = good;
  std::memset(wild.data() + wild.size() - 4, 0xff, 4);  // claims 2^32 shapes
  EXPECT_NE(failure(wild, 1).find("expected a list of the shapes"), std::string::npos);
  // Up to the checksum of what is deflated, which is not needed, nor the list after it.
  for (size_t size = 0; size + 20 < good.size(); ++size)
    EXPECT_NE(failure(Bytes(good.begin(), good.begin() + static_cast<ptrdiff_t>(size))), "")
        << size;
}

TEST(Serialized, AShapeNamesItsIndex) {
  const test::SceneFolder folder;
  const Bytes bytes = file_of({shape<float>({}, 1), shape<float>({}, 2)}, 4);
  folder.write("m.serialized",
               std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const auto loaded = folder.load(
      "scene.xml", test::mitsuba_scene("<shape type=\"serialized\">"
                                       "<string name=\"filename\" value=\"m.serialized\"/>"
                                       "<integer name=\"shapeIndex\" value=\"1\"/></shape>"));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.meshes.at(1).positions[0].z, 2);
}

}  // namespace
}  // namespace qray
