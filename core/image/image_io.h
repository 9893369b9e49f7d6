// Pictures to and from files and memory, by OpenImageIO (image_library.h). The format follows the
// name's extension. PNG, JPEG and WebP are 8-bit sRGB of the linear picture, clamped; EXR is 32-bit
// float linear. Metadata are string attributes, in the file under "qray:" and the name; callers see
// the bare name. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace qray {

using ImageMetadata = std::map<std::string, std::string>;

// Reads any format OpenImageIO knows, as stored (no colour conversion; integers become [0, 1]), at
// most `max_pixels` and the first four channels.
Result<Image> read_image(const std::filesystem::path& path, uint64_t max_pixels = 1u << 28);
// One row of it as a picture of height 1, without reading the others; not of tiled files.
Result<Image> read_image_row(const std::filesystem::path& path, int y);
// The string attributes of an image file; ours without the prefix, others as the file names them.
Result<ImageMetadata> read_image_metadata(const std::filesystem::path& path);

// Writes .exr (linear floats) or .png (sRGB) atomically.
Status write_image(const std::filesystem::path& path, const Image& image,
                   const ImageMetadata& metadata = {});

enum class ImageFormat { kExr, kPng, kJpeg, kWebp };
Result<Bytes> encode_image(ImageFormat format, const Image& image,
                           const ImageMetadata& metadata = {});

}  // namespace qray
