#include <OpenImageIO/imageio.h>

#include "core/image/tonemap.h"
#include "core/openimageio/entry.h"

namespace qray::openimageio {
namespace {

std::vector<uint8_t> to_srgb(const Image& image) {
  std::vector<uint8_t> pixels(image.data().size());
  for (size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = static_cast<uint8_t>(linear_to_srgb(image.data()[i]) * 255 + 0.5f);
  return pixels;
}

Status write_unguarded(const std::filesystem::path& path, const Animation& animation) {
  const auto failed = [&](const std::string& why) {
    return Error{ErrorCode::kIo, "cannot write the animation: " + why, path.string()};
  };
  std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path.string());
  if (!output) return failed(OIIO::geterror());
  for (int i = 0; i < animation.count; ++i) {
    const Result<Image> image = animation.picture(i);
    if (!image.ok()) return image.error();
    OIIO::ImageSpec spec(image.value().width(), image.value().height(), image.value().channels(),
                         OIIO::TypeDesc::UINT8);
    // As a fraction, which GIF rounds to hundredths of a second.
    const int rate[] = {static_cast<int>(animation.per_second * 100 + 0.5), 100};
    spec.attribute("FramesPerSecond", OIIO::TypeRational, rate);
    spec.attribute("gif:LoopCount", 0);
    const auto mode = i == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
    if (!output->open(path.string(), spec, mode) ||
        !output->write_image(OIIO::TypeDesc::UINT8, to_srgb(image.value()).data()))
      return failed(output->geterror());
  }
  return output->close() ? Status() : Status(failed(output->geterror()));
}

}  // namespace

Status write_gif(const std::filesystem::path& path, const Animation& animation) {
  try {
    return write_unguarded(path, animation);
  } catch (const std::exception& e) {
    return Error{ErrorCode::kIo, std::string("cannot write the animation: ") + e.what(),
                 path.string()};
  }
}

}  // namespace qray::openimageio
