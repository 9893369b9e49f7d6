// A picture of many layers in one EXR, of one part, whose channels are called "layer.channel", as
// compositing programs read it. By OpenImageIO (image_library.h). Any thread.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/image/image_io.h"

namespace qray {

struct PictureLayer {
  std::string name;      // empty: the picture itself, whose channels have no layer
  std::string channels;  // a letter each, as many as the image has: "RGB", "XYZ", "uv"
  Image image;
};

// All layers of one size, 32-bit floats; none twice. Metadata as encode_image() stores them, but
// names with a "/" as they are.
Result<Bytes> encode_layers(std::span<const PictureLayer> layers, const ImageMetadata& metadata);
Status write_layers(const std::filesystem::path& path, std::span<const PictureLayer> layers,
                    const ImageMetadata& metadata);

// The names of a file's layers, in its order. kNotFound: there is no such file.
Result<std::vector<std::string>> read_layer_names(const std::filesystem::path& path);
// One of them, of up to four channels. kNotFound: it has no such layer.
Result<PictureLayer> read_layer(const std::filesystem::path& path, const std::string& name);

}  // namespace qray
