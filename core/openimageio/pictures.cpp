#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "core/image/tonemap.h"
#include "core/openimageio/entry.h"
#include "core/openimageio/guarded.h"

namespace qray::openimageio {
namespace {

Result<std::unique_ptr<OIIO::ImageInput>> open_input(const std::filesystem::path& path) {
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec)) {
    return Error{ErrorCode::kNotFound, "no such picture file", path.string()};
  }
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) {
    return Error{ErrorCode::kInvalid, "expected a picture: " + OIIO::geterror(), path.string()};
  }
  return input;
}

Status check_flat(const OIIO::ImageSpec& spec, const std::string& where) {
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 || spec.deep) {
    return Error{ErrorCode::kUnsupported, "expected a flat picture", where};
  }
  return {};
}

Result<Image> read_open(OIIO::ImageInput& input, const std::string& where, uint64_t max_pixels) {
  const OIIO::ImageSpec spec = input.spec();
  if (Status s = check_flat(spec, where); !s.ok()) return s.error();
  const uint64_t pixels = static_cast<uint64_t>(spec.width) * static_cast<uint64_t>(spec.height);
  if (pixels > max_pixels) {
    return Error{
        ErrorCode::kTooLarge,
        "has " + std::to_string(pixels) + " pixels, expected at most " + std::to_string(max_pixels),
        where};
  }
  Image image(spec.width, spec.height, std::min(spec.nchannels, 4));
  if (!input.read_image(0, 0, 0, image.channels(), OIIO::TypeDesc::FLOAT, image.data().data())) {
    return Error{ErrorCode::kCorrupt, "cannot read the pixels: " + input.geterror(), where};
  }
  return image;
}

std::vector<uint8_t> to_srgb8(const Image& image) {
  std::vector<uint8_t> pixels(image.data().size());
  const int channels = image.channels();
  for (size_t i = 0; i < pixels.size(); ++i) {
    const float v = image.data()[i];
    const bool alpha = channels == 4 && i % 4 == 3;
    const float display = alpha ? std::clamp(v, 0.0f, 1.0f) : linear_to_srgb(v);
    pixels[i] = static_cast<uint8_t>(display * 255 + 0.5f);
  }
  return pixels;
}

Result<Bytes> encode_unguarded(ImageFormat format, const Image& image,
                               const ImageMetadata& metadata) {
  const bool exr = format == ImageFormat::kExr;
  if (image.empty() || image.channels() < 1 || image.channels() > 4) {
    return Error{ErrorCode::kInvalid, "expected a picture of 1 to 4 channels", ""};
  }
  OIIO::ImageSpec spec(image.width(), image.height(), image.channels(),
                       exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", exr ? "Linear" : "sRGB");
  if (exr) spec.attribute("compression", "zip");
  // Not the clock's: the bytes of a texture that an import makes are part of its scene's hash.
  if (exr) spec.attribute("DateTime", "");
  if (!exr) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (format == ImageFormat::kJpeg) spec.attribute("Compression", "jpeg:90");
  if (format == ImageFormat::kWebp) spec.attribute("Compression", "webp:85");
  for (const auto& [name, value] : metadata) {
    spec.attribute(std::string(kPrefix) + name, OIIO::string_view(value));
  }

  static constexpr const char* kNames[] = {"picture.exr", "picture.png", "picture.jpg",
                                           "picture.webp"};
  const char* name = kNames[static_cast<size_t>(format)];
  Bytes bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(name, &memory);
  if (!output || !output->open(name, spec)) {
    return Error{ErrorCode::kIo,
                 "cannot encode: " + (output ? output->geterror() : OIIO::geterror()), ""};
  }
  const bool written = exr ? output->write_image(OIIO::TypeDesc::FLOAT, image.data().data())
                           : output->write_image(OIIO::TypeDesc::UINT8, to_srgb8(image).data());
  if (!written || !output->close()) {
    return Error{ErrorCode::kIo, "cannot encode: " + output->geterror(), ""};
  }
  return bytes;
}

}  // namespace

Result<Image> read_image(const std::filesystem::path& path, uint64_t max_pixels) {
  return guarded(path.string(), [&]() -> Result<Image> {
    Result<std::unique_ptr<OIIO::ImageInput>> input = open_input(path);
    if (!input.ok()) return input.error();
    return read_open(*input.value(), path.string(), max_pixels);
  });
}

Result<Image> read_image_row(const std::filesystem::path& path, int y) {
  return guarded(path.string(), [&]() -> Result<Image> {
    Result<std::unique_ptr<OIIO::ImageInput>> input = open_input(path);
    if (!input.ok()) return input.error();
    const OIIO::ImageSpec spec = input.value()->spec();
    if (Status s = check_flat(spec, path.string()); !s.ok()) return s.error();
    if (y < 0 || y >= spec.height) {
      return Error{
          ErrorCode::kInvalid,
          "expected a row of 0.." + std::to_string(spec.height - 1) + ", got " + std::to_string(y),
          path.string()};
    }
    Image row(spec.width, 1, std::min(spec.nchannels, 4));
    if (!input.value()->read_scanlines(0, 0, spec.y + y, spec.y + y + 1, 0, 0, row.channels(),
                                       OIIO::TypeDesc::FLOAT, row.data().data())) {
      return Error{ErrorCode::kCorrupt, "cannot read a row: " + input.value()->geterror(),
                   path.string()};
    }
    return row;
  });
}

Result<ImageMetadata> read_image_metadata(const std::filesystem::path& path) {
  return guarded(path.string(), [&]() -> Result<ImageMetadata> {
    Result<std::unique_ptr<OIIO::ImageInput>> input = open_input(path);
    if (!input.ok()) return input.error();
    ImageMetadata metadata;
    for (const OIIO::ParamValue& attribute : input.value()->spec().extra_attribs) {
      if (attribute.type() != OIIO::TypeDesc::STRING) continue;
      std::string name = attribute.name().string();
      if (name.starts_with(kPrefix)) name.erase(0, kPrefix.size());
      metadata[name] = attribute.get_string();
    }
    return metadata;
  });
}

Result<Bytes> encode_image(ImageFormat format, const Image& image, const ImageMetadata& metadata) {
  return guarded("", [&] { return encode_unguarded(format, image, metadata); });
}

}  // namespace qray::openimageio
