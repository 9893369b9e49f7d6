#include "core/image/layer_view.h"

#include <bit>
#include <cmath>

#include "core/image/false_color.h"
#include "core/image/tonemap.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr float kNothing = 1e9f;  // numbers over it say that nothing is there

bool says_something(float v) { return std::isfinite(v) && std::abs(v) < kNothing; }

struct Range {
  float low = 0, high = 1;
};
Range range_of(const Image& image, int channel) {
  float low = INFINITY, high = -INFINITY;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (const float v = image.at(x, y, channel); says_something(v)) {
        low = std::min(low, v);
        high = std::max(high, v);
      }
  if (!(low <= high)) return {};
  return {low, high > low ? high : low + 1};
}

Rgb color_of(uint32_t number) {
  const uint64_t h = mix64(number + uint64_t{1});
  const auto channel = [h](int shift) {
    return 0.1f + 0.9f * static_cast<float>(h >> shift & 0xff) / 255.0f;
  };
  return {channel(0), channel(8), channel(16)};
}

// Of things by their part of the pixel.
Rgb matte_color(const Image& image, int x, int y) {
  Rgb sum;
  for (int c = 0; c < 4; c += 2)
    if (const float covered = image.at(x, y, c + 1); covered > 0)
      sum += color_of(std::bit_cast<uint32_t>(image.at(x, y, c))) * covered;
  return sum;
}

}  // namespace

Image layer_view(const PictureLayer& layer) {
  const Image& image = layer.image;
  Image out(image.width(), image.height(), 3);
  const auto fill = [&out](auto color) {
    for (int y = 0; y < out.height(); ++y)
      for (int x = 0; x < out.width(); ++x) out.set_rgb(x, y, color(x, y));
  };
  if (layer.channels == "rgba" || layer.channels == "RGBA") {
    fill([&](int x, int y) { return matte_color(image, x, y); });
  } else if (layer.channels == "RGB") {
    fill([&](int x, int y) { return image.rgb(x, y); });
  } else if (layer.name.ends_with("_id")) {
    fill([&](int x, int y) {
      const float id = image.at(x, y, 0);
      return id > 0 ? color_of(static_cast<uint32_t>(id)) : Rgb{};
    });
  } else if (image.channels() == 1) {
    const Range range = range_of(image, 0);
    fill([&](int x, int y) {
      const float v = image.at(x, y, 0);
      return says_something(v) ? viridis((v - range.low) / (range.high - range.low)) : Rgb{};
    });
  } else {
    const bool unit = layer.name.find("normal") != std::string::npos;
    std::vector<Range> ranges;
    for (int c = 0; c < image.channels(); ++c)
      ranges.push_back(unit ? Range{-1, 1} : range_of(image, c));
    fill([&](int x, int y) {
      Rgb color;
      for (int c = 0; c < std::min(image.channels(), 3); ++c) {
        const Range& range = ranges[static_cast<size_t>(c)];
        const float v = image.at(x, y, c);
        if (says_something(v)) color[c] = (v - range.low) / (range.high - range.low);
      }
      return srgb_to_linear(color);  // so that a PNG has the numbers evenly
    });
  }
  return out;
}

}  // namespace qray
