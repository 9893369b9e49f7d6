// Image textures through OpenImageIO's texture system: tiles are read on demand and kept within a
// memory limit. Bilinear lookups at full resolution. Values are what the file stores, or linear
// light where `srgb` says the file is display-encoded (decoded after the filter). Lookups: any
// thread, but not while one opens.
#pragma once

#include <array>
#include <filesystem>
#include <memory>

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

class TextureCache {
 public:
  explicit TextureCache(int max_memory_mb = 256);
  ~TextureCache();
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  // A handle for `lookup`; an error when the file is missing or no picture.
  Result<int> open(const std::filesystem::path& path, bool srgb, TextureWrap wrap);
  // v = 0 is the bottom edge. Black where the file can no longer be read or uv is beyond 2^24 or
  // NaN.
  Rgb lookup(int handle, Vec2 uv) const;
  // The same of the alpha channel as it is stored; 1 where the file has none.
  float lookup_alpha(int handle, Vec2 uv) const;
  Vec2 texel(int handle) const;  // its size in uv

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace qray
