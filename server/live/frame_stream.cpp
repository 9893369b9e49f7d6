#include "server/live/frame_stream.h"

#include "core/image/image_io.h"
#include "core/image/rgb9e5.h"

namespace qray::server {
namespace {

constexpr uint32_t kHeaderBytes = 88;

Bytes rgb9e5_of(const Image& picture) {
  Bytes bytes(static_cast<size_t>(picture.width()) * static_cast<size_t>(picture.height()) * 4);
  size_t at = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x, at += 4) put_rgb9e5(picture.rgb(x, y), &bytes[at]);
  return bytes;
}

}  // namespace

std::optional<FrameEncoding> frame_encoding_named(std::string_view name) {
  if (name == "rgb9e5") return FrameEncoding::kRgb9e5;
  if (name == "jpeg") return FrameEncoding::kJpeg;
  if (name == "webp") return FrameEncoding::kWebp;
  return {};
}

Result<Bytes> encode_frame(const ShownFrame& shown, FrameEncoding encoding) {
  const LiveFrame& frame = shown.frame;
  Bytes picture;
  if (encoding == FrameEncoding::kRgb9e5) {
    picture = rgb9e5_of(frame.picture);
  } else {
    Result<Bytes> encoded = encode_image(
        encoding == FrameEncoding::kJpeg ? ImageFormat::kJpeg : ImageFormat::kWebp, frame.picture);
    if (!encoded.ok()) return encoded.error();
    picture = std::move(encoded).value();
  }
  ByteWriter out;
  for (char c : {'Q', 'R', 'L', '1'}) out.u8(static_cast<uint8_t>(c));
  out.u32(kHeaderBytes);
  out.u32(static_cast<uint32_t>(picture.size()));
  out.u8(static_cast<uint8_t>(encoding));
  out.u8(static_cast<uint8_t>(frame.stage));
  out.u8(frame.guided ? 1 : 0);
  out.u8(static_cast<uint8_t>(frame.scale * 100 + 0.5));
  out.u64(frame.number);
  out.u64(shown.camera);
  out.u32(static_cast<uint32_t>(frame.picture.width()));
  out.u32(static_cast<uint32_t>(frame.picture.height()));
  const LiveTimes& t = frame.times;
  for (const double seconds :
       {t.features, t.reprojection, t.samples, t.learning, t.recovery, t.whole})
    out.f32(static_cast<float>(seconds * 1000));
  out.f32(static_cast<float>(frame.samples_per_pixel));
  out.f32(static_cast<float>(frame.noise));
  out.u64(frame.paths);
  out.u64(frame.rays);
  out.bytes(picture);
  return out.take();
}

}  // namespace qray::server
