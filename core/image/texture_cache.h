// Image textures: pictures of levels, every one half the size of the one below. Where all are
// small, read() makes them at once. Else a picture's level is made of the file when a lookup first
// needs one, with the coarser ones on the way, and when one needs a finer level, all of them are.
// Averages are of linear light. OpenImageIO reads the files. Lookups: any thread, but not while
// one opens or all are read; what they give does not depend on their order.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/math/vec.h"

namespace qray {

enum class TextureWrap { kRepeat, kClamp, kMirror };

// u' = u[0] u + u[1] v + u[2], v' = v[0] u + v[1] v + v[2].
struct UvTransform {
  std::array<float, 3> u{1, 0, 0}, v{0, 1, 0};
  Vec2 operator()(Vec2 uv) const {
    return {u[0] * uv.x + u[1] * uv.y + u[2], v[0] * uv.x + v[1] * uv.y + v[2]};
  }
  bool operator==(const UvTransform&) const = default;
};

struct Texture {
  std::filesystem::path path;  // absolute once loaded; with `bytes`: a name for messages
  bool srgb = true;            // display-encoded, as 8-bit colour pictures are
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  bool nearest = false;                // texels are squares, not interpolated
  UvTransform uv_transform;            // from the mesh's uv to the picture's, v = 0 at its bottom
  bool second_uvs = false;             // of the mesh's second set
  std::shared_ptr<const Bytes> bytes;  // the picture's file, where it is not one on disk
};

// Where to look a texture up.
struct TexturePoint {
  TexturePoint() = default;
  TexturePoint(Vec2 uv_, float width_ = 0)
      : uv(uv_), width(width_), second_uv(uv_), second_width(width_) {}
  Vec2 uv;  // the mesh's
  float width =
      0;  // in uv, of the surface that the sample stands for: detail below it may be averaged
  Vec2 second_uv;  // of the mesh's second set, where it has one
  float second_width = 0;
};

class TextureCache {
 public:
  // Textures that would take more than `max_bytes` in all lose their finest levels, the largest
  // first.
  explicit TextureCache(size_t max_bytes = size_t{1} << 30);
  ~TextureCache();
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  // A handle for `lookup`; an error when the file is missing or no picture.
  Result<int> open(const Texture& texture);
  // Makes all levels of all pictures, unless they take more than `most_bytes` together.
  void read(int threads, size_t most_bytes = size_t{256} << 20);
  // v = 0 is the bottom edge. Linear where the texture is display-encoded, else what the file
  // stores. Texels are at most a third as wide as the point's width, or the finest. Black where the
  // file can no longer be read or uv is beyond 2^24 or NaN.
  Rgb lookup(int handle, TexturePoint at) const;
  // The same of the alpha channel; 1 where the file has none.
  float lookup_alpha(int handle, TexturePoint at) const;
  Vec2 texel(int handle) const;  // its size in the mesh's uv
  size_t size_bytes() const;     // of the levels that are there

 private:
  class Picture;
  size_t max_bytes_;
  std::vector<std::unique_ptr<Picture>> pictures_;
};

}  // namespace qray
