#include "core/image/texture_cache.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>

#include "core/image/picture_reader.h"
#include "core/image/tonemap.h"

namespace qray {
namespace {

constexpr size_t kMaxLevels = 32;
constexpr int64_t kMaxTexels = int64_t{1} << 30;

// No fraction is left beyond; also stops NaN.
bool is_near(Vec2 uv) {
  constexpr float kFarthest = 0x1p24f;
  return std::abs(uv.x) < kFarthest && std::abs(uv.y) < kFarthest;
}

// Into [0, 1], with the texels beyond either end as the wrap has them.
float wrap(float u, TextureWrap mode) {
  if (mode == TextureWrap::kRepeat) return u - std::floor(u);
  if (mode == TextureWrap::kClamp) return std::clamp(u, 0.0f, 1.0f);
  const float m = u - 2 * std::floor(0.5f * u);
  return m > 1 ? 2 - m : m;
}
int wrap(int i, int count, TextureWrap mode) {
  if (mode == TextureWrap::kRepeat) return i < 0 ? count - 1 : i >= count ? 0 : i;
  return std::clamp(i, 0, count - 1);
}

// Stored 8-bit values as linear light.
const std::array<float, 256>& linear_of_srgb() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (size_t i = 0; i < 256; ++i) t[i] = srgb_to_linear(static_cast<float>(i) / 255);
    return t;
  }();
  return table;
}

const std::array<float, 256>& linear_of_byte() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (size_t i = 0; i < 256; ++i) t[i] = static_cast<float>(i) / 255;
    return t;
  }();
  return table;
}

// A stored 8-bit value of linear light: as linear_to_srgb() would have it, without its power.
class SrgbBytes {
 public:
  SrgbBytes() {
    for (int b = 1; b < 256; ++b) {
      float lo = 0, hi = 1;  // the least value of byte b lies above lo, and not above hi
      while (std::nextafter(lo, hi) < hi) {
        const float middle = 0.5f * (lo + hi);
        (slow(middle) >= b ? hi : lo) = middle;
      }
      least_[static_cast<size_t>(b)] = hi;
    }
    size_t b = 0;
    for (size_t i = 0; i < first_.size(); ++i) {
      while (b < 255 && least_[b + 1] <= static_cast<float>(i) / kParts) ++b;
      first_[i] = static_cast<uint8_t>(b);
    }
  }
  uint8_t operator()(float v) const {
    if (!(v > 0)) return 0;
    size_t b = first_[static_cast<size_t>(std::min(v, 1.0f) * kParts)];
    while (b < 255 && v >= least_[b + 1]) ++b;
    return static_cast<uint8_t>(b);
  }

 private:
  static constexpr int kParts = 1024;
  static int slow(float v) { return static_cast<int>(linear_to_srgb(v) * 255 + 0.5f); }
  std::array<float, 256> least_{};
  std::array<uint8_t, kParts + 1> first_{};
};

uint8_t srgb_byte(float linear) {
  static const SrgbBytes bytes;
  return bytes(linear);
}

}  // namespace

class TextureCache::Picture {
 public:
  Picture(const Texture& texture, const PictureInfo& info) : texture_(texture), info_(info) {
    while (level_count_ < kMaxLevels &&
           (width(level_count_ - 1) > 1 || height(level_count_ - 1) > 1))
      ++level_count_;
    // A step of one in the mesh's u, or v, in texels.
    const auto& u = texture.uv_transform.u;
    const auto& v = texture.uv_transform.v;
    const auto w = static_cast<float>(info.width), h = static_cast<float>(info.height);
    texels_per_uv_ = {std::hypot(u[0] * w, v[0] * h), std::hypot(u[1] * w, v[1] * h)};
  }

  Vec2 texel() const {
    constexpr float kLeast = 1e-6f;
    return {1 / std::max(texels_per_uv_.x, kLeast), 1 / std::max(texels_per_uv_.y, kLeast)};
  }
  bool has_alpha() const { return info_.alpha_channel >= 0; }

  // Bytes of this level and all above.
  size_t bytes_from(size_t level) const {
    size_t sum = 0;
    for (size_t l = level; l < level_count_; ++l)
      sum += value_count(l) * (info_.is_8_bit ? 1 : sizeof(float));
    return sum;
  }
  size_t finest() const { return finest_; }
  bool can_lose_finest() const { return finest_ + 1 < level_count_; }
  void lose_finest() { ++finest_; }
  size_t size_bytes() const {
    size_t sum = 0;
    for (const auto& level : levels_)
      if (const Level* l = level.load()) sum += l->bytes.size() + l->floats.size() * sizeof(float);
    return sum;
  }

  struct Value {
    float channel[4] = {0, 0, 0, 0};
  };
  Value lookup(TexturePoint at) const;
  void read_all() const { (void)level(finest_); }
  Rgb color(const Value& v) const {
    const int colors = info_.channels - (has_alpha() ? 1 : 0);
    return colors == 1 ? Rgb{v.channel[0]} : Rgb{v.channel[0], v.channel[1], v.channel[2]};
  }
  float alpha(const Value& v) const { return v.channel[info_.alpha_channel]; }

 private:
  struct Level {
    int width, height;
    std::vector<uint8_t> bytes;  // as stored: of 8-bit pictures
    std::vector<float> floats;   // linear: of others
  };
  using Levels = std::vector<std::unique_ptr<Level>>;
  using Waiting = std::vector<std::vector<float>>;  // a level's even row, until the next is there
  int width(size_t level) const { return shrunk(info_.width, level); }
  int height(size_t level) const { return shrunk(info_.height, level); }
  static int shrunk(int size, size_t level) {
    return static_cast<int>((static_cast<int64_t>(size) + (int64_t{1} << level) - 1) >> level);
  }
  size_t value_count(size_t level) const {
    return static_cast<size_t>(width(level)) * static_cast<size_t>(height(level)) *
           static_cast<size_t>(info_.channels);
  }
  bool is_encoded(int channel) const { return texture_.srgb && channel != info_.alpha_channel; }
  size_t level_for(float width) const;
  const Level& level(size_t index) const;
  void read(size_t index) const;
  void add_row(Levels& out, Waiting& waiting, size_t level, size_t row,
               std::vector<float> values) const;
  void store(Level& level, size_t row, std::span<const float> values) const;
  Status read_floats(Levels& out, Waiting& waiting) const;
  Status read_bytes(Levels& out, Waiting& waiting) const;
  std::vector<float> mean_of(std::span<const uint8_t> row, std::span<const uint8_t> other) const;
  void fetch(const Level& level, int x, int y, float weight, Value& out) const;

  const Texture texture_;
  const PictureInfo info_;
  size_t level_count_ = 1, finest_ = 0;
  Vec2 texels_per_uv_;
  mutable std::mutex reading_;
  mutable std::array<std::atomic<const Level*>, kMaxLevels> levels_{};
  mutable std::vector<std::unique_ptr<Level>> owned_;
};

// Texels of at most a third of the width: they then add at most a third to the variance of a
// pixel's own box.
size_t TextureCache::Picture::level_for(float width) const {
  const float texels = width * std::min(texels_per_uv_.x, texels_per_uv_.y);
  if (!(texels >= 6) || texture_.nearest) return finest_;
  return std::clamp(static_cast<size_t>(std::ilogb(texels / 3)), finest_, level_count_ - 1);
}

const TextureCache::Picture::Level& TextureCache::Picture::level(size_t index) const {
  if (const Level* there = levels_[index].load(std::memory_order_acquire)) return *there;
  const std::lock_guard guard(reading_);
  if (!levels_[index].load(std::memory_order_relaxed)) read(owned_.empty() ? index : finest_);
  return *levels_[index].load(std::memory_order_relaxed);
}

// Every level is averaged from the file's texels on, whichever was asked for: the bits are the
// same.
void TextureCache::Picture::read(size_t index) const {
  Levels made(level_count_);
  for (size_t l = index; l < level_count_ && !levels_[l].load(); ++l) {
    made[l] = std::make_unique<Level>(Level{width(l), height(l), {}, {}});
    if (info_.is_8_bit)
      made[l]->bytes.resize(value_count(l));
    else
      made[l]->floats.resize(value_count(l));
  }
  Waiting waiting(level_count_);
  // A file that breaks off leaves the rest black.
  (void)(info_.is_8_bit ? read_bytes(made, waiting) : read_floats(made, waiting));
  for (size_t l = level_count_; l-- > 0;) {
    if (!made[l]) continue;
    levels_[l].store(made[l].get(), std::memory_order_release);
    owned_.push_back(std::move(made[l]));
  }
}

Status TextureCache::Picture::read_floats(Levels& out, Waiting& waiting) const {
  size_t row = 0;
  return read_picture_rows(
      texture_.path, texture_.bytes.get(), info_.height, [&](std::span<const float> stored) {
        const auto channels = static_cast<size_t>(info_.channels);
        std::vector<float> linear(stored.begin(), stored.end());
        linear.resize(static_cast<size_t>(info_.width) * channels);  // if the file changed
        for (size_t c = 0; c < channels; ++c)
          for (size_t i = c; i < linear.size() && is_encoded(static_cast<int>(c)); i += channels)
            linear[i] = srgb_to_linear(linear[i]);
        add_row(out, waiting, 0, row++, std::move(linear));
      });
}

// The finest level as it is stored; means are of linear light.
Status TextureCache::Picture::read_bytes(Levels& out, Waiting& waiting) const {
  const size_t size = static_cast<size_t>(info_.width) * static_cast<size_t>(info_.channels);
  const auto height = static_cast<size_t>(info_.height);
  size_t row = 0;
  std::vector<uint8_t> values(size), above;
  return read_picture_bytes(
      texture_.path, texture_.bytes.get(), info_.height, [&](std::span<const uint8_t> stored) {
        if (row >= height) return;
        std::copy_n(stored.begin(), std::min(size, stored.size()), values.begin());
        if (out[0])
          std::copy(values.begin(), values.end(),
                    out[0]->bytes.begin() + static_cast<ptrdiff_t>(row * size));
        if (level_count_ > 1 && (row % 2 == 1 || row + 1 == height))
          add_row(out, waiting, 1, row / 2, mean_of(values, row % 2 == 1 ? above : values));
        above.swap(values);
        values.resize(size);
        ++row;
      });
}

// Of two rows, and of two columns each.
std::vector<float> TextureCache::Picture::mean_of(std::span<const uint8_t> row,
                                                  std::span<const uint8_t> other) const {
  const auto channels = static_cast<size_t>(info_.channels);
  const auto count = static_cast<size_t>(info_.width);
  const size_t half = (count + 1) / 2;
  std::vector<float> mean(half * channels);
  for (size_t c = 0; c < channels; ++c) {
    const auto& linear = is_encoded(static_cast<int>(c)) ? linear_of_srgb() : linear_of_byte();
    for (size_t x = 0; x < half; ++x) {
      const size_t a = 2 * x * channels + c, b = std::min(2 * x + 1, count - 1) * channels + c;
      mean[x * channels + c] =
          0.25f * (linear[row[a]] + linear[row[b]] + linear[other[a]] + linear[other[b]]);
    }
  }
  return mean;
}

// Keeps a row of linear values, and hands its mean with the one before it to the next level.
void TextureCache::Picture::add_row(Levels& out, Waiting& waiting, size_t level, size_t row,
                                    std::vector<float> values) const {
  if (row >= static_cast<size_t>(height(level))) return;
  if (out[level]) store(*out[level], row, values);
  if (level + 1 == level_count_) return;
  const bool last = row + 1 == static_cast<size_t>(height(level));
  if (row % 2 == 0 && !last) {
    waiting[level] = std::move(values);
    return;
  }
  const std::vector<float>& other = row % 2 ? waiting[level] : values;
  const size_t channels = static_cast<size_t>(info_.channels);
  const size_t count = static_cast<size_t>(width(level)), half = (count + 1) / 2;
  std::vector<float> mean(half * channels);
  for (size_t x = 0; x < half; ++x) {
    const size_t a = 2 * x * channels, b = std::min(2 * x + 1, count - 1) * channels;
    for (size_t c = 0; c < channels; ++c)
      mean[x * channels + c] =
          0.25f * (values[a + c] + values[b + c] + other[a + c] + other[b + c]);
  }
  add_row(out, waiting, level + 1, row / 2, std::move(mean));
}

void TextureCache::Picture::store(Level& level, size_t row, std::span<const float> values) const {
  const size_t begin = row * values.size();
  if (!info_.is_8_bit) {
    std::copy(values.begin(), values.end(), level.floats.begin() + static_cast<ptrdiff_t>(begin));
    return;
  }
  const auto channels = static_cast<size_t>(info_.channels);
  for (size_t c = 0; c < channels; ++c) {
    const bool encoded = is_encoded(static_cast<int>(c));
    for (size_t i = c; i < values.size(); i += channels)
      level.bytes[begin + i] =
          encoded ? srgb_byte(values[i])
                  : static_cast<uint8_t>(std::clamp(values[i], 0.0f, 1.0f) * 255 + 0.5f);
  }
}

void TextureCache::Picture::fetch(const Level& level, int x, int y, float weight,
                                  Value& out) const {
  const size_t at =
      (static_cast<size_t>(y) * static_cast<size_t>(level.width) + static_cast<size_t>(x)) *
      static_cast<size_t>(info_.channels);
  for (int c = 0; c < info_.channels; ++c) {
    const size_t i = at + static_cast<size_t>(c);
    const float v = !info_.is_8_bit ? level.floats[i]
                    : is_encoded(c) ? linear_of_srgb()[level.bytes[i]]
                                    : static_cast<float>(level.bytes[i]) * (1 / 255.0f);
    out.channel[c] += weight * v;
  }
}

TextureCache::Picture::Value TextureCache::Picture::lookup(TexturePoint at) const {
  Value out;
  const Vec2 uv = texture_.uv_transform(at.uv);
  if (!is_near(uv)) return out;
  const size_t index = level_for(at.width);
  const Level& l = level(index);
  const float scale = std::ldexp(1.0f, -static_cast<int>(index));
  const float x = wrap(uv.x, texture_.wrap_u) * static_cast<float>(info_.width) * scale;
  const float y = wrap(1 - uv.y, texture_.wrap_v) * static_cast<float>(info_.height) * scale;
  const auto column = [&](int i) { return wrap(i, l.width, texture_.wrap_u); };
  const auto row = [&](int i) { return wrap(i, l.height, texture_.wrap_v); };
  if (texture_.nearest) {
    fetch(l, column(std::min(static_cast<int>(x), l.width - 1)),
          row(std::min(static_cast<int>(y), l.height - 1)), 1, out);
    return out;
  }
  const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
  const float fx = x - 0.5f - left, fy = y - 0.5f - top;
  const int x0 = static_cast<int>(left), y0 = static_cast<int>(top);
  fetch(l, column(x0), row(y0), (1 - fx) * (1 - fy), out);
  fetch(l, column(x0 + 1), row(y0), fx * (1 - fy), out);
  fetch(l, column(x0), row(y0 + 1), (1 - fx) * fy, out);
  fetch(l, column(x0 + 1), row(y0 + 1), fx * fy, out);
  return out;
}

TextureCache::TextureCache(size_t max_bytes) : max_bytes_(max_bytes) {}
TextureCache::~TextureCache() = default;

Result<int> TextureCache::open(const Texture& texture) {
  const Result<PictureInfo> info = read_picture_info(texture.path, texture.bytes.get());
  if (!info) return info.error();
  if (int64_t{info.value().width} * info.value().height > kMaxTexels) {
    return Error{ErrorCode::kTooLarge, "expected at most 2^30 texels", texture.path.string()};
  }
  const Status first_row = read_picture_rows(texture.path, texture.bytes.get(), 1, [](auto) {});
  if (!first_row.ok()) return first_row.error();
  pictures_.push_back(std::make_unique<Picture>(texture, info.value()));
  for (;;) {
    size_t total = 0, most = 0;
    Picture* largest = nullptr;
    for (const auto& picture : pictures_) {
      const size_t bytes = picture->bytes_from(picture->finest());
      total += bytes;
      if (bytes > most && picture->can_lose_finest()) most = bytes, largest = picture.get();
    }
    if (total <= max_bytes_ || !largest) break;
    largest->lose_finest();
  }
  return static_cast<int>(pictures_.size()) - 1;
}

void TextureCache::read(int threads, size_t most_bytes) {
  size_t bytes = 0;
  for (const auto& picture : pictures_) bytes += picture->bytes_from(picture->finest());
  if (bytes > most_bytes) return;
  std::atomic<size_t> next = 0;
  std::vector<std::jthread> readers;
  for (int t = 0; t < std::min(threads, static_cast<int>(pictures_.size())); ++t)
    readers.emplace_back([&] {
      try {
        for (size_t i = next++; i < pictures_.size(); i = next++) pictures_[i]->read_all();
      } catch (const std::bad_alloc&) {  // a lookup tries again
      }
    });
}

Rgb TextureCache::lookup(int handle, TexturePoint at) const {
  const Picture& picture = *pictures_[static_cast<size_t>(handle)];
  return picture.color(picture.lookup(at));
}

float TextureCache::lookup_alpha(int handle, TexturePoint at) const {
  const Picture& picture = *pictures_[static_cast<size_t>(handle)];
  return picture.has_alpha() ? picture.alpha(picture.lookup(at)) : 1;
}

Vec2 TextureCache::texel(int handle) const {
  return pictures_[static_cast<size_t>(handle)]->texel();
}

size_t TextureCache::size_bytes() const {
  size_t sum = 0;
  for (const auto& picture : pictures_) sum += picture->size_bytes();
  return sum;
}

}  // namespace qray
