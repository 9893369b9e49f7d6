#include "tests/crash/plain_pictures.h"

#include <algorithm>

#include "core/base/file.h"

namespace qray::server::test {
namespace {

constexpr size_t kMostText = 1 << 20;

Result<Bytes> encode(ImageFormat, const Image& image, const ImageMetadata& metadata) {
  ByteWriter out;
  for (const int v : {image.width(), image.height(), image.channels()})
    out.u32(static_cast<uint32_t>(v));
  for (const float v : image.data()) out.f32(v);
  for (const auto& [name, value] : metadata) {
    out.string(name);
    out.string(value);
  }
  return out.take();
}

struct Picture {
  Image image;
  ImageMetadata metadata;
};

Result<Picture> read(const std::filesystem::path& path) {
  const Result<Bytes> bytes = read_file(path, uint64_t{1} << 20);
  if (!bytes.ok()) return bytes.error();
  ByteReader in(bytes.value());
  const int width = static_cast<int>(in.u32()), height = static_cast<int>(in.u32());
  Picture picture{Image(width, height, static_cast<int>(in.u32())), {}};
  for (float& v : picture.image.data()) v = in.f32();
  while (in.ok() && in.remaining() > 0) {
    const std::string name = in.string(kMostText);
    picture.metadata[name] = in.string(kMostText);
  }
  if (!in.ok()) return Error{ErrorCode::kCorrupt, "torn picture", path.string()};
  return picture;
}

Result<Image> read_pixels(const std::filesystem::path& path, uint64_t) {
  Result<Picture> picture = read(path);
  if (!picture.ok()) return picture.error();
  return std::move(picture.value().image);
}

Result<Image> read_row(const std::filesystem::path& path, int y) {
  Result<Picture> picture = read(path);
  if (!picture.ok()) return picture.error();
  const Image& all = picture.value().image;
  Image row(all.width(), 1, all.channels());
  const auto values = all.data().subspan(row.data().size() * static_cast<size_t>(y));
  std::copy_n(values.begin(), row.data().size(), row.data().begin());
  return row;
}

Result<ImageMetadata> read_metadata(const std::filesystem::path& path) {
  Result<Picture> picture = read(path);
  if (!picture.ok()) return picture.error();
  return std::move(picture.value().metadata);
}

}  // namespace

const ImageLibrary& plain_pictures() {
  static constexpr ImageLibrary kLibrary{.read_image = read_pixels,
                                         .read_image_row = read_row,
                                         .read_image_metadata = read_metadata,
                                         .encode_image = encode,
                                         .encode_layers = nullptr,
                                         .read_layer_names = nullptr,
                                         .read_layer = nullptr,
                                         .write_gif = nullptr,
                                         .read_picture_info = nullptr,
                                         .read_picture_rows = nullptr,
                                         .read_picture_bytes = nullptr};
  return kLibrary;
}

}  // namespace qray::server::test
