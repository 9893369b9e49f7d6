#include "core/import/serialized.h"

#include <zlib.h>

#include <cstring>

#include "core/import/import_failure.h"

namespace qray {
namespace {

constexpr uint16_t kMagic = 0x041C;
constexpr uint64_t kDeflateLimit = 1032;  // no deflated byte holds more
enum Flags : uint32_t {
  kHasNormals = 0x1,
  kHasUvs = 0x2,
  kHasColors = 0x8,
  kFaceNormals = 0x10,
  kDouble = 0x2000  // else float
};

[[noreturn]] void fail(const std::string& file, size_t offset, const std::string& message,
                       ErrorCode code = ErrorCode::kCorrupt) {
  fail_import(code, message, file + " at byte " + std::to_string(offset));
}

template <class T>
T read_at(std::span<const uint8_t> bytes, size_t offset, const std::string& file) {
  if (offset > bytes.size() || bytes.size() - offset < sizeof(T))
    fail(file, offset, "the file ends too early");
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// What follows a shape's header, inflated as it is asked for.
class Inflated {
 public:
  Inflated(std::span<const uint8_t> deflated, size_t offset, const std::string& file)
      : offset_(offset), file_(file), deflated_bytes_(deflated.size()) {
    stream_.next_in = const_cast<Bytef*>(deflated.data());  // zlib's interface; it only reads
    stream_.avail_in = static_cast<uInt>(deflated.size());
    if (inflateInit(&stream_) != Z_OK) throw std::bad_alloc();
  }
  ~Inflated() { inflateEnd(&stream_); }
  Inflated(const Inflated&) = delete;
  Inflated& operator=(const Inflated&) = delete;

  void read(void* to, size_t bytes) {
    constexpr size_t kMost = size_t{1} << 30;
    auto* at = static_cast<Bytef*>(to);
    while (bytes > 0) {
      stream_.next_out = at;
      stream_.avail_out = static_cast<uInt>(std::min(bytes, kMost));
      const uInt asked = stream_.avail_out;
      const int state = inflate(&stream_, Z_NO_FLUSH);
      const size_t got = asked - stream_.avail_out;
      at += got;
      bytes -= got;
      if (bytes > 0 && (state != Z_OK || got == 0))
        fail(file_, offset_, "expected deflated data of the shape, and more of it");
    }
  }
  template <class T>
  T value() {
    T out;
    read(&out, sizeof out);
    return out;
  }
  // Refuses a count that so few bytes cannot hold, before memory is taken for it.
  void check_count(uint64_t count, uint64_t bytes_each) const {
    if (count > deflated_bytes_ * kDeflateLimit / bytes_each)
      fail(file_, offset_, "is too short for the " + std::to_string(count) + " that it claims");
  }

 private:
  z_stream stream_{};
  size_t offset_;
  const std::string& file_;
  uint64_t deflated_bytes_;
};

// Where each shape starts, by the list at the file's end; a file without one has one shape.
size_t shape_offset(std::span<const uint8_t> bytes, size_t index, uint16_t version,
                    const std::string& file) {
  if (index == 0) return 0;
  const size_t each = version >= 4 ? sizeof(uint64_t) : sizeof(uint32_t);
  const size_t end = bytes.size() - sizeof(uint32_t);
  const auto count = read_at<uint32_t>(bytes, end, file);
  if (count > end / each) fail(file, end, "expected a list of the shapes at the file's end");
  if (index >= count) {
    fail(file, end,
         "has " + std::to_string(count) + " shapes, none of index " + std::to_string(index),
         ErrorCode::kInvalid);
  }
  const size_t at = end - (count - index) * each;
  return version >= 4 ? read_at<uint64_t>(bytes, at, file) : read_at<uint32_t>(bytes, at, file);
}

template <class Number, class Vector>
void read_vectors(Inflated& in, std::vector<Vector>& out, size_t count, int size) {
  std::vector<Number> numbers(count * static_cast<size_t>(size));
  in.read(numbers.data(), numbers.size() * sizeof(Number));
  out.resize(count);
  const Number* from = numbers.data();
  for (Vector& v : out) {
    float* const to = &v.x;
    for (int i = 0; i < size; ++i) to[i] = static_cast<float>(*from++);
  }
}

// Indices are of 32 bits: more would be needed only for more vertices than the limit allows.
void read_triangles(Inflated& in, Mesh& mesh, size_t count, const std::string& file,
                    size_t offset) {
  mesh.triangles.resize(count);
  in.read(mesh.triangles.data(), count * sizeof mesh.triangles[0]);
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t v : triangle) {
      if (v < mesh.positions.size()) continue;
      fail(file, offset,
           "expected vertex indices below " + std::to_string(mesh.positions.size()) + ", got " +
               std::to_string(v));
    }
  }
}

template <class Number>
void read_vertices(Inflated& in, uint32_t flags, size_t count, Mesh& mesh) {
  read_vectors<Number>(in, mesh.positions, count, 3);
  if (flags & kHasNormals) read_vectors<Number>(in, mesh.normals, count, 3);
  if (flags & kHasUvs) read_vectors<Number>(in, mesh.uvs, count, 2);
  std::vector<Vec3> passed_over;
  if (flags & kHasColors) read_vectors<Number>(in, passed_over, count, 3);
}

// A mesh with a normal without length is drawn with computed ones.
void finish_normals(Mesh& mesh) {
  for (Vec3& n : mesh.normals) {
    const float norm = length(n);
    if (!(norm > 0 && std::isfinite(norm))) return mesh.normals.clear();
    n = n / norm;
  }
}

}  // namespace

SerializedShape read_serialized(std::span<const uint8_t> bytes, size_t shape_index,
                                const SceneLimits& limits, const std::string& file) {
  if (read_at<uint16_t>(bytes, 0, file) != kMagic)
    fail(file, 0, "expected a Mitsuba .serialized file", ErrorCode::kInvalid);
  const auto version = read_at<uint16_t>(bytes, 2, file);
  if (version != 3 && version != 4)
    fail(file, 2, "expected version 3 or 4, got " + std::to_string(version),
         ErrorCode::kUnsupported);
  const size_t offset = shape_offset(bytes, shape_index, version, file);
  if (read_at<uint16_t>(bytes, offset, file) != kMagic)
    fail(file, offset, "expected the start of a shape");
  Inflated in(bytes.subspan(std::min(offset + 4, bytes.size())), offset, file);

  SerializedShape out;
  const auto flags = in.value<uint32_t>();
  if (version >= 4) {
    for (char c = in.value<char>(); c != 0; c = in.value<char>()) {
      out.mesh.name += c;
      if (out.mesh.name.size() > 4096) fail(file, offset, "expected a name of at most 4096 bytes");
    }
  }
  const auto vertex_count = in.value<uint64_t>(), triangle_count = in.value<uint64_t>();
  if (triangle_count > limits.max_triangles || vertex_count > 3 * limits.max_triangles) {
    fail(file, offset, "expected at most " + std::to_string(limits.max_triangles) + " triangles",
         ErrorCode::kTooLarge);
  }
  in.check_count(vertex_count, 3 * sizeof(float));
  in.check_count(triangle_count, 3 * sizeof(uint32_t));
  if (flags & kDouble)
    read_vertices<double>(in, flags, vertex_count, out.mesh);
  else
    read_vertices<float>(in, flags, vertex_count, out.mesh);
  read_triangles(in, out.mesh, triangle_count, file, offset);
  finish_normals(out.mesh);
  out.face_normals = (flags & kFaceNormals) != 0;
  return out;
}

}  // namespace qray
