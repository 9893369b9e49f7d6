#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "core/openimageio/entry.h"

namespace qray::openimageio {
namespace {

constexpr int kRowsAtOnce = 64;

// What OpenImageIO goes by where a picture in memory has no file name.
std::string name_of_kind(const Bytes& bytes) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                               std::min<size_t>(bytes.size(), 16));
  constexpr std::pair<std::string_view, const char*> kKinds[] = {
      {"\x89PNG", "memory.png"}, {"\xff\xd8", "memory.jpg"}, {"\x76\x2f\x31\x01", "memory.exr"},
      {"#?", "memory.hdr"},      {"BM", "memory.bmp"},       {"GIF8", "memory.gif"}};
  for (const auto& [magic, name] : kKinds)
    if (start.starts_with(magic)) return name;
  return start.starts_with("RIFF") ? "memory.webp" : "memory.tga";
}

Error not_a_picture(const std::filesystem::path& path, const std::string& why) {
  return {ErrorCode::kInvalid, "expected a picture: " + why, path.string()};
}

// An open file, and what it reads from.
struct Opened {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  std::unique_ptr<OIIO::ImageInput> input;
};

Result<Opened> open(const std::filesystem::path& path, const Bytes* bytes) {
  Opened opened;
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (bytes) {
    opened.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes->data(), bytes->size());
    OIIO::Filesystem::IOProxy* proxy = opened.memory.get();
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    opened.input = OIIO::ImageInput::open(name_of_kind(*bytes), &config, proxy);
  } else {
    std::error_code ec;
    if (!std::filesystem::is_regular_file(path, ec))
      return Error{ErrorCode::kNotFound, "no such texture file", path.string()};
    opened.input = OIIO::ImageInput::open(path.string(), &config);
  }
  if (!opened.input) return not_a_picture(path, OIIO::geterror());
  const OIIO::ImageSpec& spec = opened.input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.depth > 1)
    return not_a_picture(path, "its size is odd");
  return opened;
}

template <class T>
Status read_rows(OIIO::ImageInput& input, int row_limit,
                 const std::function<void(std::span<const T>)>& row) {
  const OIIO::ImageSpec spec = input.spec();
  const int channels = std::min(spec.nchannels, 4);
  const size_t row_size = static_cast<size_t>(spec.width) * static_cast<size_t>(channels);
  const bool tiled = spec.tile_width > 0;
  const int step = tiled ? spec.tile_height : std::min(kRowsAtOnce, row_limit);
  constexpr OIIO::TypeDesc::BASETYPE kType =
      std::is_same_v<T, float> ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
  const bool from_bytes = std::is_same_v<T, float> && spec.format == OIIO::TypeDesc::UINT8;
  std::vector<T> rows(row_size * static_cast<size_t>(step));
  for (int y = 0; y < std::min(spec.height, row_limit); y += step) {
    const int begin = spec.y + y, end = spec.y + std::min(y + step, spec.height);
    const bool good =
        tiled ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, 0, 1, 0, channels,
                                 kType, rows.data())
              : input.read_scanlines(0, 0, begin, end, 0, 0, channels, kType, rows.data());
    if (!good) return Error{ErrorCode::kInvalid, input.geterror(), ""};
    if (from_bytes)
      for (T& v : rows) v = static_cast<T>(v * 255);
    for (int i = 0; i < end - begin; ++i)
      row(std::span<const T>(rows).subspan(static_cast<size_t>(i) * row_size, row_size));
  }
  return {};
}

}  // namespace

Result<PictureInfo> read_picture_info(const std::filesystem::path& path, const Bytes* bytes) {
  try {
    Result<Opened> opened = open(path, bytes);
    if (!opened) return opened.error();
    const OIIO::ImageSpec& spec = opened.value().input->spec();
    return PictureInfo{spec.width, spec.height, std::min(spec.nchannels, 4),
                       spec.alpha_channel < 4 ? spec.alpha_channel : -1,
                       spec.format == OIIO::TypeDesc::UINT8};
  } catch (const std::exception& e) {
    return not_a_picture(path, e.what());
  }
}

namespace {

template <class T>
Status open_and_read(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                     const std::function<void(std::span<const T>)>& row) {
  try {
    Result<Opened> opened = open(path, bytes);
    if (!opened) return opened.error();
    const Status status = read_rows(*opened.value().input, row_limit, row);
    if (!status.ok()) return not_a_picture(path, status.error().message);
    return {};
  } catch (const std::exception& e) {
    return not_a_picture(path, e.what());
  }
}

}  // namespace

Status read_picture_rows(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                         const std::function<void(std::span<const float>)>& row) {
  return open_and_read(path, bytes, row_limit, row);
}

Status read_picture_bytes(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                          const std::function<void(std::span<const uint8_t>)>& row) {
  return open_and_read(path, bytes, row_limit, row);
}

}  // namespace qray::openimageio
