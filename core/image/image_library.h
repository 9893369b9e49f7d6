// What reads and writes picture files: OpenImageIO, which brings some 265 shared libraries. Loading
// them takes .2 s of processor time, so a library of ours (core/openimageio) has it behind these
// functions and is loaded when the first of them is needed. Any thread.
#pragma once

#include "core/image/animation.h"
#include "core/image/image_io.h"
#include "core/image/picture_layers.h"
#include "core/image/picture_reader.h"

namespace qray {

// As the functions of the same names in the headers above.
struct ImageLibrary {
  Result<Image> (*read_image)(const std::filesystem::path& path, uint64_t max_pixels);
  Result<Image> (*read_image_row)(const std::filesystem::path& path, int y);
  Result<ImageMetadata> (*read_image_metadata)(const std::filesystem::path& path);
  Result<Bytes> (*encode_image)(ImageFormat format, const Image& image,
                                const ImageMetadata& metadata);
  Result<Bytes> (*encode_layers)(std::span<const PictureLayer> layers,
                                 const ImageMetadata& metadata);
  Result<std::vector<std::string>> (*read_layer_names)(const std::filesystem::path& path);
  Result<PictureLayer> (*read_layer)(const std::filesystem::path& path, const std::string& name);
  Status (*write_gif)(const std::filesystem::path& path, const Animation& animation);
  Result<PictureInfo> (*read_picture_info)(const std::filesystem::path& path, const Bytes* bytes);
  Status (*read_picture_rows)(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                              const std::function<void(std::span<const float>)>& row);
  Status (*read_picture_bytes)(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                               const std::function<void(std::span<const uint8_t>)>& row);
};

// The one function that the library exports, and its type.
constexpr const char* kImageLibraryEntry = "qray_image_library";
using ImageLibraryEntry = const ImageLibrary*();

// `file`: a library with that entry. It stays loaded. kIo: it cannot be loaded.
Result<const ImageLibrary*> open_image_library(const std::filesystem::path& file);
// From now on `library` instead of the one that comes with qray: before the first picture.
void use_image_library(const ImageLibrary& library);
// The one that comes with qray, opened by the first call.
const Result<const ImageLibrary*>& image_library();

}  // namespace qray
