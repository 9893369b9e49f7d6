#include "core/image/image_library.h"

#include <dlfcn.h>

#include "core/base/file.h"
#include "core/base/installed.h"

namespace qray {
namespace {

const ImageLibrary* library_instead = nullptr;

// Calls a function of the library, or says why there is none.
template <class R, class... Params, class... Args>
R call(R (*ImageLibrary::*function)(Params...), const Args&... args) {
  const Result<const ImageLibrary*>& library = image_library();
  if (!library.ok()) return library.error();
  return (library.value()->*function)(args...);
}

}  // namespace

Result<const ImageLibrary*> open_image_library(const std::filesystem::path& file) {
  void* const library = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  void* const entry = library ? ::dlsym(library, kImageLibraryEntry) : nullptr;
  if (!entry) {
    const char* why = ::dlerror();
    return Error{ErrorCode::kIo,
                 std::string("cannot load what reads and writes pictures: ") + (why ? why : "?"),
                 file.string()};
  }
  return reinterpret_cast<ImageLibraryEntry*>(entry)();
}

void use_image_library(const ImageLibrary& library) { library_instead = &library; }

const Result<const ImageLibrary*>& image_library() {
  static const Result<const ImageLibrary*> library =
      library_instead
          ? Result<const ImageLibrary*>(library_instead)
          : open_image_library(beside_program("lib/qray/qray_openimageio.so", QRAY_IMAGE_LIBRARY));
  return library;
}

Result<Image> read_image(const std::filesystem::path& path, uint64_t max_pixels) {
  return call(&ImageLibrary::read_image, path, max_pixels);
}

Result<Image> read_image_row(const std::filesystem::path& path, int y) {
  return call(&ImageLibrary::read_image_row, path, y);
}

Result<ImageMetadata> read_image_metadata(const std::filesystem::path& path) {
  return call(&ImageLibrary::read_image_metadata, path);
}

Status write_image(const std::filesystem::path& path, const Image& image,
                   const ImageMetadata& metadata) {
  const std::string extension = path.extension().string();
  if (extension != ".exr" && extension != ".png") {
    return Error{ErrorCode::kUnsupported, "expected a name ending in .exr or .png", path.string()};
  }
  const ImageFormat format = extension == ".exr" ? ImageFormat::kExr : ImageFormat::kPng;
  const Result<Bytes> bytes = encode_image(format, image, metadata);
  if (!bytes.ok()) return Error{bytes.error().code, bytes.error().message, path.string()};
  return write_file_atomic(path, bytes.value());
}

Result<Bytes> encode_image(ImageFormat format, const Image& image, const ImageMetadata& metadata) {
  return call(&ImageLibrary::encode_image, format, image, metadata);
}

Result<Bytes> encode_layers(std::span<const PictureLayer> layers, const ImageMetadata& metadata) {
  return call(&ImageLibrary::encode_layers, layers, metadata);
}

Result<std::vector<std::string>> read_layer_names(const std::filesystem::path& path) {
  return call(&ImageLibrary::read_layer_names, path);
}

Result<PictureLayer> read_layer(const std::filesystem::path& path, const std::string& name) {
  return call(&ImageLibrary::read_layer, path, name);
}

Result<PictureInfo> read_picture_info(const std::filesystem::path& path, const Bytes* bytes) {
  return call(&ImageLibrary::read_picture_info, path, bytes);
}

Status read_picture_rows(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                         const std::function<void(std::span<const float>)>& row) {
  return call(&ImageLibrary::read_picture_rows, path, bytes, row_limit, row);
}

Status read_picture_bytes(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                          const std::function<void(std::span<const uint8_t>)>& row) {
  return call(&ImageLibrary::read_picture_bytes, path, bytes, row_limit, row);
}

}  // namespace qray
