#include "core/import/gltf_texture.h"

#include <algorithm>
#include <climits>

#include "core/image/image_io.h"
#include "core/image/picture_reader.h"
#include "core/import/upward_uv.h"

namespace qray {
namespace {

TextureWrap to_wrap(int gl) {
  if (gl == kGltfClamp) return TextureWrap::kClamp;
  return gl == kGltfMirror ? TextureWrap::kMirror : TextureWrap::kRepeat;
}

// offset + rotation (scale uv); the rotation runs clockwise where v is down, so that it is counter-
// clockwise as uv are drawn.
UvTransform read_uv_transform(const JsonNode& node) {
  std::vector<float> offset{0, 0}, scale{1, 1};
  if (const auto v = node.find("offset")) offset = v->numbers(2);
  if (const auto v = node.find("scale")) scale = v->numbers(2);
  double angle = 0;
  if (const auto v = node.find("rotation")) angle = v->number(-1e6f, 1e6f);
  const double c = std::cos(angle), s = std::sin(angle);
  return upward(c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]);
}

}  // namespace

// The picture that a texture shows: the plain one first, which everyone can read.
std::optional<int> GltfTextures::find_source(int texture) {
  const GltfModel::Texture& t = import_.document.model().textures[static_cast<size_t>(texture)];
  const JsonNode node = import_.document.at("textures", texture);
  if (t.source >= 0) return t.source;
  const size_t images = import_.document.count("images");
  if (const auto webp = find_extension(node, "EXT_texture_webp"); webp && images > 0)
    return webp->get("source").integer(0, static_cast<int>(images) - 1);
  import_.expect_extensions(node, {});
  if (!node.has("extensions")) import_.warn(node, "has no source and is left out");
  return {};
}

std::optional<int> GltfTextures::uv_set(const JsonNode& node, std::string_view key) {
  const std::optional<JsonNode> info = node.find(key);
  if (!info) return {};
  if (const auto transform = find_extension(*info, "KHR_texture_transform"))
    if (const auto set = transform->find("texCoord")) return set->integer(0, INT_MAX);
  const auto set = info->find("texCoord");
  return set ? set->integer(0, INT_MAX) : 0;
}

TextureId GltfTextures::find(const JsonNode& node, std::string_view key, bool srgb,
                             bool second_uvs) {
  const std::optional<JsonNode> info = node.find(key);
  if (!info) return {};
  const size_t count = import_.document.model().textures.size();
  const JsonNode index_node = info->get("index");
  if (count == 0) index_node.fail("expected no index, there are no textures");
  const int index = index_node.integer(0, static_cast<int>(count) - 1);
  Texture texture;
  texture.srgb = srgb;
  texture.second_uvs = second_uvs;
  import_.expect_extensions(*info, {"KHR_texture_transform"});
  if (const auto transform = find_extension(*info, "KHR_texture_transform"))
    texture.uv_transform = read_uv_transform(*transform);
  const auto& [u, v] = texture.uv_transform;
  const auto [it, is_new] = known_.try_emplace(
      {index, srgb, second_uvs, {u[0], u[1], u[2], v[0], v[1], v[2]}}, TextureId{});
  if (is_new) {
    const GltfModel& model = import_.document.model();
    const int sampler = model.textures[static_cast<size_t>(index)].sampler;
    if (sampler >= 0) {
      const GltfModel::Sampler& s = model.samplers[static_cast<size_t>(sampler)];
      texture.wrap_u = to_wrap(s.wrap_s);
      texture.wrap_v = to_wrap(s.wrap_t);
      texture.nearest = s.mag_filter == kGltfNearest;
    }
    if (const std::optional<int> source = find_source(index)) {
      const GltfDocument::Picture picture = import_.document.read_picture(*source);
      texture.path = picture.path;
      texture.bytes = picture.bytes;
      it->second = add(std::move(texture));
    }
  }
  return it->second;
}

TextureId GltfTextures::complement_of_alpha(const JsonNode& info, TextureId id, float scale) {
  const auto [known, is_new] = complements_.try_emplace({id, scale}, TextureId{});
  if (!is_new) return known->second;
  Texture texture = import_.out.scene.textures[id.value];
  const auto check = [&info](const auto& result) {
    if (!result.ok()) info.fail(result.error().message, result.error().code);
  };
  const Result<PictureInfo> picture = read_picture_info(texture.path, texture.bytes.get());
  check(picture);
  const int width = picture.value().width, height = picture.value().height;
  texels_made_ += int64_t{width} * height;
  if (texels_made_ > 8 * import_.limits.max_pixels) {
    import_.warn(info, "too many texels of glossiness: drawn with the factor alone");
    return {};
  }
  Image image(width, height, 1);
  int y = 0;
  check(
      read_picture_rows(texture.path, texture.bytes.get(), height, [&](std::span<const float> row) {
        const auto channels = static_cast<size_t>(picture.value().channels);
        for (int x = 0; x < width && y < height; ++x) {
          const int alpha = picture.value().alpha_channel;
          const size_t at = static_cast<size_t>(x) * channels + static_cast<size_t>(alpha);
          const float a = alpha < 0 ? 1 : row[at] / (picture.value().is_8_bit ? 255.0f : 1.0f);
          image.at(x, y, 0) = std::clamp(1 - scale * a, 0.0f, 1.0f);
        }
        ++y;
      }));
  Result<Bytes> bytes = encode_image(ImageFormat::kExr, image);
  check(bytes);
  texture.path = info.place() + ".exr";  // a name of its own
  texture.srgb = false;
  texture.bytes = std::make_shared<const Bytes>(std::move(bytes).value());
  return known->second = add(std::move(texture));
}

TextureId GltfTextures::add(Texture texture) {
  std::vector<Texture>& textures = import_.out.scene.textures;
  textures.push_back(std::move(texture));
  return TextureId(static_cast<uint32_t>(textures.size() - 1));
}

}  // namespace qray
