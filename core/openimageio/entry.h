// What this library's files give its entry: the functions of core/image/image_library.h, by
// OpenImageIO. Any thread.
#pragma once

#include "core/image/image_library.h"

namespace qray::openimageio {

Result<Image> read_image(const std::filesystem::path& path, uint64_t max_pixels);
Result<Image> read_image_row(const std::filesystem::path& path, int y);
Result<ImageMetadata> read_image_metadata(const std::filesystem::path& path);
Result<Bytes> encode_image(ImageFormat format, const Image& image, const ImageMetadata& metadata);
Result<Bytes> encode_layers(std::span<const PictureLayer> layers, const ImageMetadata& metadata);
Result<std::vector<std::string>> read_layer_names(const std::filesystem::path& path);
Result<PictureLayer> read_layer(const std::filesystem::path& path, const std::string& name);
Status write_gif(const std::filesystem::path& path, const Animation& animation);
Result<PictureInfo> read_picture_info(const std::filesystem::path& path, const Bytes* bytes);
Status read_picture_rows(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                         const std::function<void(std::span<const float>)>& row);
Status read_picture_bytes(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                          const std::function<void(std::span<const uint8_t>)>& row);

}  // namespace qray::openimageio
