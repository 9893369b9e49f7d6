#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>

#include "core/openimageio/entry.h"
#include "core/openimageio/guarded.h"

namespace qray::openimageio {
namespace {

std::string channel_name(const PictureLayer& layer, size_t channel) {
  const std::string letter(1, layer.channels[channel]);
  return layer.name.empty() ? letter : layer.name + "." + letter;
}

// What stands before the last dot.
std::string layer_of(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  return dot == std::string::npos ? std::string() : channel.substr(0, dot);
}

// The layers' rows side by side.
void gather_row(std::span<const PictureLayer> layers, int y, std::vector<float>& row) {
  auto out = row.begin();
  for (int x = 0; x < layers.front().image.width(); ++x)
    for (const PictureLayer& layer : layers)
      for (int c = 0; c < layer.image.channels(); ++c) *out++ = layer.image.at(x, y, c);
}

Result<Bytes> encode_rows(std::span<const PictureLayer> layers, const ImageMetadata& metadata) {
  if (layers.empty()) return Error{ErrorCode::kInvalid, "expected a layer or more", ""};
  const int width = layers.front().image.width(), height = layers.front().image.height();
  std::vector<std::string> channels;
  for (const PictureLayer& layer : layers) {
    const bool fits = layer.image.width() == width && layer.image.height() == height &&
                      layer.channels.size() == static_cast<size_t>(layer.image.channels());
    if (!fits)
      return Error{ErrorCode::kInvalid, "expected layers of one size and a letter a channel",
                   layer.name};
    for (size_t c = 0; c < layer.channels.size(); ++c) channels.push_back(channel_name(layer, c));
  }
  OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames = channels;
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("compression", "zip");
  spec.attribute("DateTime", "");  // the same picture has the same bytes
  for (const auto& [name, value] : metadata) {
    const bool as_it_is = name.find('/') != std::string::npos;
    spec.attribute(as_it_is ? name : std::string(kPrefix) + name, OIIO::string_view(value));
  }
  Bytes bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("layers.exr", &memory);
  const auto failed = [&] {
    return Error{ErrorCode::kIo,
                 "cannot encode: " + (output ? output->geterror() : OIIO::geterror()), ""};
  };
  if (!output || !output->open("layers.exr", spec)) return failed();
  // Rows in blocks, as many as are compressed together.
  constexpr int kRowsAtOnce = 64;
  const size_t row_values = static_cast<size_t>(width) * channels.size();
  std::vector<float> row(row_values), block;
  for (int y = 0; y < height; y += kRowsAtOnce) {
    const int end = std::min(y + kRowsAtOnce, height);
    block.clear();
    for (int at = y; at < end; ++at) {
      gather_row(layers, at, row);
      block.insert(block.end(), row.begin(), row.end());
    }
    if (!output->write_scanlines(y, end, 0, OIIO::TypeDesc::FLOAT, block.data())) return failed();
  }
  if (!output->close()) return failed();
  return bytes;
}

Result<std::unique_ptr<OIIO::ImageInput>> open_layers(const std::filesystem::path& path) {
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec))
    return Error{ErrorCode::kNotFound, "no such picture file", path.string()};
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (!input) return Error{ErrorCode::kInvalid, OIIO::geterror(), path.string()};
  return input;
}

}  // namespace

Result<Bytes> encode_layers(std::span<const PictureLayer> layers, const ImageMetadata& metadata) {
  return guarded("", [&] { return encode_rows(layers, metadata); });
}

Result<std::vector<std::string>> read_layer_names(const std::filesystem::path& path) {
  return guarded(path.string(), [&]() -> Result<std::vector<std::string>> {
    Result<std::unique_ptr<OIIO::ImageInput>> input = open_layers(path);
    if (!input.ok()) return input.error();
    std::vector<std::string> names;
    for (const std::string& channel : input.value()->spec().channelnames)
      if (const std::string name = layer_of(channel); std::ranges::find(names, name) == names.end())
        names.push_back(name);
    return names;
  });
}

// A reader puts the channels of a layer side by side.
Result<PictureLayer> read_layer(const std::filesystem::path& path, const std::string& name) {
  return guarded(path.string(), [&]() -> Result<PictureLayer> {
    Result<std::unique_ptr<OIIO::ImageInput>> input = open_layers(path);
    if (!input.ok()) return input.error();
    const OIIO::ImageSpec spec = input.value()->spec();
    const auto is_of_it = [&](const std::string& channel) { return layer_of(channel) == name; };
    const auto first = std::ranges::find_if(spec.channelnames, is_of_it);
    if (first == spec.channelnames.end())
      return Error{ErrorCode::kNotFound, "has no layer '" + name + "'", path.string()};
    PictureLayer layer{name, "", {}};
    for (auto at = first; at != spec.channelnames.end() && is_of_it(*at); ++at)
      layer.channels += at->back();
    const auto begin = static_cast<int>(first - spec.channelnames.begin());
    const auto count = static_cast<int>(layer.channels.size());
    layer.image = Image(spec.width, spec.height, count);
    if (!input.value()->read_image(0, 0, begin, begin + count, OIIO::TypeDesc::FLOAT,
                                   layer.image.data().data()))
      return Error{ErrorCode::kCorrupt, "cannot read the pixels: " + input.value()->geterror(),
                   path.string()};
    return layer;
  });
}

}  // namespace qray::openimageio
