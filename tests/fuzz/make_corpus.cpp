// Writes the binary files of the corpus: `make_corpus tests/fuzz/corpus`. The others are written by
// hand, or were found by the targets.
#include <bit>
#include <cstdio>

#include "core/base/file.h"
#include "core/guide/open_table.h"
#include "core/math/warp.h"
#include "core/recover/pyramid.h"
#include "core/recover/weights_file.h"
#include "tests/support/random.h"

namespace qray::fuzz {
namespace {

constexpr std::string_view kTriangle = R"({"asset":{"version":"2.0"},"scene":0,
"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[1]},{"camera":0,"translation":[0,0,3]}],
"cameras":[{"type":"perspective","perspective":{"yfov":1}}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"emissiveFactor":[1,1,1]}],
"textures":[{"source":0}],"images":[{"bufferView":4,"mimeType":"image/png"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3,
"material":0}]}],
"buffers":[{"byteLength":116}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},
{"buffer":0,"byteOffset":72,"byteLength":24},{"buffer":0,"byteOffset":96,"byteLength":6},
{"buffer":0,"byteOffset":104,"byteLength":12}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
{"bufferView":1,"componentType":5126,"type":"VEC3","count":3},
{"bufferView":2,"componentType":5126,"type":"VEC2","count":3},
{"bufferView":3,"componentType":5123,"type":"SCALAR","count":3}]})";
constexpr float kPositions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
constexpr float kNormals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
constexpr float kUvs[] = {0, 0, 1, 0, 0, 1};

void put_floats(ByteWriter& out, std::span<const float> values) {
  for (const float v : values) out.f32(v);
}

void put_text(ByteWriter& out, std::string_view text) {
  for (const char c : text) out.u8(static_cast<uint8_t>(c));
}

Bytes glb() {
  ByteWriter binary;
  put_floats(binary, kPositions);
  put_floats(binary, kNormals);
  put_floats(binary, kUvs);
  for (const int i : {0, 1, 2, 0}) binary.u16(static_cast<uint16_t>(i));
  put_text(binary, "P6 1 1 255\nq");
  std::string json(kTriangle);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  ByteWriter out;
  put_text(out, "glTF");
  out.u32(2);
  out.u32(static_cast<uint32_t>(28 + json.size() + binary.size()));
  out.u32(static_cast<uint32_t>(json.size()));
  put_text(out, "JSON");
  put_text(out, json);
  out.u32(static_cast<uint32_t>(binary.size()));
  put_text(out, std::string_view("BIN\0", 4));
  out.bytes(binary.data());
  return out.take();
}

Bytes ply(std::endian order) {
  const bool big = order == std::endian::big;
  ByteWriter out;
  put_text(out, std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                    "property float z\nproperty uchar s\nproperty double t\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n");
  const auto put = [&](uint64_t bits, int bytes) {
    for (int i = 0; i < bytes; ++i)
      out.u8(static_cast<uint8_t>(bits >> 8 * (big ? bytes - 1 - i : i)));
  };
  for (size_t v = 0; v < 3; ++v) {
    for (size_t axis = 0; axis < 3; ++axis)
      put(std::bit_cast<uint32_t>(kPositions[3 * v + axis]), 4);
    put(v, 1);
    put(std::bit_cast<uint64_t>(0.5), 8);
  }
  put(3, 1);
  for (uint64_t v = 0; v < 3; ++v) put(v, 4);
  return out.take();
}

// What a .serialized file holds deflated: serialized_fuzz.cpp.
Bytes serialized(bool doubles) {
  ByteWriter out;
  out.u32(0x1 | 0x2 | (doubles ? 0x2000u : 0x10u));
  put_text(out, std::string_view("mesh\0", 5));
  out.u64(3);
  out.u64(1);
  for (const std::span<const float> values :
       {std::span<const float>(kPositions), std::span<const float>(kNormals),
        std::span<const float>(kUvs)}) {
    if (!doubles) {
      put_floats(out, values);
      continue;
    }
    for (const float v : values) out.f64(static_cast<double>(v));
  }
  for (const uint32_t v : {0, 1, 2}) out.u32(v);
  return out.take();
}

Bytes serialized_file() {
  const Bytes content = serialized(false);
  const auto size = static_cast<uint16_t>(content.size());
  ByteWriter out;
  for (const uint16_t v : {0x041c, 4, 0x0178}) out.u16(v);
  out.u8(1);  // a deflated block, stored as it is
  out.u16(size);
  out.u16(static_cast<uint16_t>(~size));
  out.bytes(content);
  out.u64(0);
  out.u64(0);
  out.u32(2);  // both shapes are the same
  return out.take();
}

// A few events in a corner of a room.
Bytes table(std::string_view method) {
  constexpr int kPasses = 3, kEvents = 150;
  GuideSetup setup;
  setup.bounds = {{-1, -1, -1}, {1, 1, 1}};
  setup.huang.grid = 4;
  setup.adaptive.split_samples = 100;
  const std::unique_ptr<Guide> guide = make_guide(method, setup).value();
  test::Random random(1);
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::unique_ptr<GuideDelta> delta = guide->make_delta();
    for (int i = 0; i < kEvents; ++i) {
      const Vec3 n = i % 2 == 0 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
      GuideVertex v;
      v.p = {0.1f * random.next(), 0.1f * random.next(), 0.9f * random.next()};
      v.at = guide->find(v.p, n);
      v.guidable = true;
      const Vec3 local = square_to_cosine_hemisphere(random.next_2d());
      v.wi = Frame(n).to_world(local);
      v.pdf_w = v.bsdf.pdf_w = cosine_hemisphere_pdf_w(local.z);
      v.bsdf.f_cos = 0.5f * v.pdf_w;
      v.transition.emitted = 10 * random.next();
      v.arriving = Rgb{v.transition.emitted};
      guide->record({&v, 1}, *delta);
    }
    guide->update(*delta);
    guide->end_pass();
  }
  TableFile file;
  file.header.method = table_method(method);
  file.header.program = "fuzz";
  file.header.samples_seen = guide->stats().samples_seen;
  file.sections = guide->save();
  file.header.id = table_id(file);
  return encode_table(file);
}

Bytes weights() {
  WeightsFile file;
  file.program = "fuzz";
  file.scene = "a room";
  file.held_out = {0.5f, 0.25f};
  file.network = untrained_network(1);
  file.id = weights_id(file);
  return encode_weights(file);
}

bool write_all(const std::filesystem::path& folder) {
  const auto write = [&](const std::string& name, const Bytes& bytes) {
    std::filesystem::create_directories((folder / name).parent_path());
    return write_file_atomic(folder / name, bytes).ok();
  };
  bool ok = write("glb/triangle.glb", glb());
  ok = ok && write("ply/little.ply", ply(std::endian::little));
  ok = ok && write("ply/big.ply", ply(std::endian::big));
  ok = ok && write("serialized/floats", serialized(false));
  ok = ok && write("serialized/doubles", serialized(true));
  ok = ok && write("serialized/two_shapes.serialized", serialized_file());
  for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"})
    ok = ok && write(std::string("table/") + method + ".qrt", table(method));
  return ok && write("weights/untrained.qrw", weights());
}

}  // namespace
}  // namespace qray::fuzz

int main(int argc, char** argv) {
  if (argc == 2 && qray::fuzz::write_all(argv[1])) return 0;
  std::fputs("usage: make_corpus FOLDER\n", stderr);
  return 1;
}
