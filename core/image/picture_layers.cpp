#include "core/image/picture_layers.h"

#include "core/base/file.h"

namespace qray {

Status write_layers(const std::filesystem::path& path, std::span<const PictureLayer> layers,
                    const ImageMetadata& metadata) {
  const Result<Bytes> bytes = encode_layers(layers, metadata);
  if (!bytes.ok()) return Error{bytes.error().code, bytes.error().message, path.string()};
  return write_file_atomic(path, bytes.value());
}

}  // namespace qray
