#include "core/render/cryptomatte.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <map>

#include "core/math/murmur.h"

namespace qray {
namespace {

std::string hex(uint32_t value) {
  char text[9];
  std::snprintf(text, sizeof text, "%08x", value);
  return text;
}

// As a JSON string.
std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) {
      char escape[7];
      std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(c));
      out += escape;
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

}  // namespace

uint32_t cryptomatte_id(std::string_view name) {
  const uint32_t hash = murmur3_32(name), exponent = hash >> 23 & 0xff;
  return exponent == 0 || exponent == 0xff ? hash ^ 1u << 23 : hash;
}

Cryptomatte::Cryptomatte(int width, int height, std::string layer, std::vector<std::string> names)
    : name_(std::move(layer)), names_(std::move(names)) {
  for (const std::string& name : names_) ids_.push_back(cryptomatte_id(name));
  for (int i = 0; i < kRanks / 2; ++i)
    layers_.push_back({name_ + "0" + std::to_string(i), "rgba", Image(width, height, 4)});
}

void Cryptomatte::set(int x, int y, std::span<const int> things) {
  struct Covered {
    uint32_t id;
    int rays;
  };
  std::array<Covered, 64> found;
  size_t count = 0;
  for (const int thing : things) {
    if (thing < 0) continue;
    const uint32_t id = ids_[static_cast<size_t>(thing)];
    const auto end = found.begin() + static_cast<std::ptrdiff_t>(count);
    const auto at = std::find_if(found.begin(), end, [&](const Covered& c) { return c.id == id; });
    if (at != end)
      ++at->rays;
    else if (count < found.size())
      found[count++] = {id, 1};
  }
  std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Covered& a, const Covered& b) {
              return a.rays != b.rays ? a.rays > b.rays : a.id < b.id;
            });
  for (size_t i = 0; i < std::min<size_t>(count, kRanks); ++i) {
    Image& image = layers_[i / 2].image;
    const int channel = static_cast<int>(i % 2) * 2;
    image.at(x, y, channel) = std::bit_cast<float>(found[i].id);
    image.at(x, y, channel + 1) =
        static_cast<float>(found[i].rays) / static_cast<float>(things.size());
  }
}

std::vector<PictureLayer> Cryptomatte::take_layers() { return std::move(layers_); }

ImageMetadata Cryptomatte::metadata() const {
  const std::string key = "cryptomatte/" + hex(murmur3_32(name_)).substr(0, 7) + "/";
  std::map<std::string, uint32_t> manifest;
  for (size_t i = 0; i < names_.size(); ++i) manifest.emplace(names_[i], ids_[i]);
  std::string text = "{";
  for (const auto& [name, id] : manifest)
    text += (text.size() > 1 ? "," : "") + json_text(name) + ":\"" + hex(id) + "\"";
  return {{key + "name", name_},
          {key + "hash", "MurmurHash3_32"},
          {key + "conversion", "uint32_to_float32"},
          {key + "manifest", text + "}"}};
}

}  // namespace qray
