#include "core/import/mitsuba_texture.h"

#include <algorithm>
#include <cmath>

#include "core/image/image_io.h"
#include "core/image/tonemap.h"
#include "core/import/upward_uv.h"

namespace qray {
namespace {

constexpr int kMaxTextureDepth = 16;  // of textures in textures

TextureWrap read_wrap(const MitsubaNode& node, std::string_view name, TextureWrap fallback,
                      MitsubaImport& import) {
  const std::string* text = find_text(node, name);
  if (!text) return fallback;
  if (*text == "repeat") return TextureWrap::kRepeat;
  if (*text == "clamp") return TextureWrap::kClamp;
  if (*text == "mirror") return TextureWrap::kMirror;
  import.warn(*find_parameter(node, name), "wrap mode \"" + *text + "\" is drawn as clamp");
  return TextureWrap::kClamp;
}

UvTransform read_uv_transform(const MitsubaNode& node) {
  if (const std::optional<Transform> t = find_transform(node, "to_uv")) {
    const auto& r = t->rows;
    return upward(r[0][0], r[0][1], r[0][3], r[1][0], r[1][1], r[1][3]);
  }
  const double scale = find_number(node, "uvscale").value_or(1);
  return upward(
      find_number(node, "uscale").value_or(scale), 0, find_number(node, "uoffset").value_or(0), 0,
      find_number(node, "vscale").value_or(scale), find_number(node, "voffset").value_or(0));
}

bool holds_linear_light(const std::filesystem::path& path) {
  std::string extension = path.extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".exr" || extension == ".hdr" || extension == ".rgbe" || extension == ".pfm";
}

bool is_srgb(const MitsubaNode& node, const std::filesystem::path& path, MitsubaImport& import) {
  if (holds_linear_light(path)) return false;
  if (const std::optional<bool> raw = find_flag(node, "raw")) return !*raw;
  const double gamma = find_number(node, "gamma").value_or(-1);
  if (gamma == 1) return false;
  if (gamma > 0)
    import.warn(*find_parameter(node, "gamma"),
                "the picture is read with the curve of sRGB, not this gamma");
  return true;
}

}  // namespace

ColorParam MitsubaTextures::find_color(const MitsubaNode& plugin, std::string_view name,
                                       Rgb fallback, ColorUse use) {
  const MitsubaNode* parameter = find_parameter(plugin, name);
  if (!parameter) return {fallback, {}};
  const MitsubaNode& node = import_.document.resolve(*parameter);
  if (node.tag == "texture") return read(node);
  if (!is_color(node)) parameter->fail("expected a colour or a texture, got <" + node.tag + ">");
  Rgb color = read_mitsuba_color(node, use, import_);
  if (use == ColorUse::kReflectance && max_component(color) > 1) {
    import_.warn(*parameter, "a reflectance over 1 is drawn as 1");
    for (int i = 0; i < 3; ++i) color[i] = std::min(color[i], 1.0f);
  }
  return {color, {}};
}

FloatParam MitsubaTextures::find_share(const MitsubaNode& plugin, std::string_view name,
                                       float fallback) {
  const ColorParam color = find_color(plugin, name, Rgb{fallback});
  return {luminance(color.value), color.texture, color.texture.valid() ? kLuminance : 0};
}

FloatParam MitsubaTextures::find_opacity(const MitsubaNode& plugin) {
  FloatParam opacity = find_share(plugin, "opacity", 0.5f);
  if (!opacity.texture.valid()) return opacity;
  const Texture& texture = import_.out.scene.textures[opacity.texture.value];
  if (texture.bytes) return opacity;
  const Result<Image> image =
      read_image(texture.path, static_cast<uint64_t>(import_.limits.max_pixels));
  if (!image.ok()) find_parameter(plugin, "opacity")->fail(image.error().message);
  if (image.value().channels() == 4) {
    opacity.channel = 3;
    import_.warn(*find_parameter(plugin, "opacity"), "opacity is the picture's alpha");
  }
  return opacity;
}

float MitsubaTextures::read_alpha_value(const MitsubaNode& parameter) {
  const double alpha = parse_number(parameter, parameter.need("value"));
  if (!(alpha >= 0)) parameter.fail("expected a roughness from 0, got " + std::to_string(alpha));
  if (alpha > 1) import_.warn(parameter, "a roughness over 1 is drawn as 1");
  return static_cast<float>(std::min(alpha, 1.0));
}

void MitsubaTextures::find_roughness(const MitsubaNode& plugin, Material& out) {
  const MitsubaNode* const u = find_parameter(plugin, "alpha_u");
  const MitsubaNode* const v = find_parameter(plugin, "alpha_v");
  const auto is_texture = [&](const MitsubaNode& parameter) {
    return import_.document.resolve(parameter).tag == "texture";
  };
  if (!find_parameter(plugin, "alpha") && u && v) {
    if (!is_texture(*u) && !is_texture(*v))
      return set_roughness(out, read_alpha_value(*u), read_alpha_value(*v));
    import_.warn(*v, "roughness is drawn the same in all directions, as alpha_u has it");
  }
  out.roughness = find_isotropic(plugin);
}

void set_roughness(Material& out, float alpha_u, float alpha_v) {
  const float least = std::min(alpha_u, alpha_v), most = std::max(alpha_u, alpha_v);
  out.roughness.value = std::sqrt(least);
  if (most > least) out.anisotropy.value = std::sqrt((most - least) / (1 - least));
  if (alpha_v > alpha_u) out.anisotropy_rad = kPi / 2;
}

FloatParam MitsubaTextures::find_isotropic(const MitsubaNode& plugin) {
  constexpr float kUsualAlpha = 0.1f;
  const MitsubaNode* parameter = find_parameter(plugin, "alpha");
  if (!parameter) parameter = find_parameter(plugin, "alpha_u");
  if (!parameter) return {std::sqrt(kUsualAlpha), {}, 0};
  const MitsubaNode& node = import_.document.resolve(*parameter);
  if (node.tag != "texture") return {std::sqrt(read_alpha_value(*parameter)), {}, 0};
  // The picture's root, pixel by pixel.
  const ColorParam alpha = read(node);
  if (!alpha.texture.valid()) return {std::sqrt(std::min(luminance(alpha.value), 1.0f)), {}, 0};
  const Texture texture = import_.out.scene.textures[alpha.texture.value];
  if (texture.bytes) {
    import_.warn(*parameter, "a roughness of this texture is drawn as its mean");
    return {std::sqrt(std::min(0.5f * luminance(alpha.value), 1.0f)), {}, 0};
  }
  Result<Image> image = read_image(texture.path, static_cast<uint64_t>(import_.limits.max_pixels));
  if (!image.ok()) parameter->fail(image.error().message, image.error().code);
  Image roots(image.value().width(), image.value().height(), 3);
  for (int y = 0; y < roots.height(); ++y) {
    for (int x = 0; x < roots.width(); ++x) {
      const float stored = image.value().rgb(x, y).r;
      const float value = texture.srgb ? srgb_to_linear(stored) : stored;
      roots.set_rgb(x, y, Rgb{std::sqrt(std::clamp(value, 0.0f, 1.0f))});
    }
  }
  return {std::sqrt(alpha.value.r), add_in_memory(*parameter, roots, texture), 0};
}

ColorParam MitsubaTextures::read(const MitsubaNode& node) {
  if (const std::string* name = find_text(node, "name");
      node.type == "mesh_attribute" && name && *name == "vertex_color") {
    vertex_colors_ = true;
    return {Rgb{static_cast<float>(find_number(node, "scale").value_or(1))}, {}};
  }
  if (const auto it = known_.find(&node); it != known_.end()) return it->second;
  if (++depth_ > kMaxTextureDepth) node.fail("expected textures of at most 16 levels, no cycles");
  ColorParam color;
  if (node.type == "bitmap") {
    color = read_bitmap(node);
  } else if (node.type == "checkerboard") {
    color = read_checkerboard(node);
  } else if (node.type == "scale") {
    color = read_scale(node);
  } else {
    import_.warn(node, "textures of type \"" + node.type + "\" are drawn as grey");
    color = {Rgb{0.5f}, {}};
  }
  --depth_;
  known_.emplace(&node, color);
  return color;
}

ColorParam MitsubaTextures::read_bitmap(const MitsubaNode& node) {
  const MitsubaNode* file = find_parameter(node, "filename");
  if (!file) node.fail("expected a \"filename\" of the bitmap");
  import_.expect_only(node, {"filename", "filter_type", "gamma", "raw", "wrap_mode", "wrap_mode_u",
                             "wrap_mode_v", "to_uv", "uvscale", "uscale", "vscale", "uoffset",
                             "voffset", "max_anisotropy", "cache", "accel", "format"});
  Texture texture;
  texture.path = import_.document.find_file(*file, file->need("value"));
  texture.srgb = is_srgb(node, texture.path, import_);
  const TextureWrap wrap = read_wrap(node, "wrap_mode", TextureWrap::kRepeat, import_);
  texture.wrap_u = read_wrap(node, "wrap_mode_u", wrap, import_);
  texture.wrap_v = read_wrap(node, "wrap_mode_v", wrap, import_);
  const std::string* filter = find_text(node, "filter_type");
  texture.nearest = filter && *filter == "nearest";
  texture.uv_transform = read_uv_transform(node);
  return {Rgb{1.0f}, add(std::move(texture))};
}

// 2 x 2 texels: exactly the pattern, edges and all.
ColorParam MitsubaTextures::read_checkerboard(const MitsubaNode& node) {
  import_.expect_only(node, {"color0", "color1", "to_uv", "uvscale", "uscale", "vscale", "uoffset",
                             "voffset", "filter_type"});
  const ColorParam same = find_color(node, "color0", Rgb{0.4f});
  const ColorParam other = find_color(node, "color1", Rgb{0.2f});
  if (same.texture.valid() || other.texture.valid())
    import_.warn(node, "textures within a checkerboard are drawn as one colour");
  Image image(2, 2, 3);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) image.set_rgb(x, y, x == y ? same.value : other.value);
  Texture texture;
  texture.nearest = true;
  texture.uv_transform = read_uv_transform(node);
  return {Rgb{1.0f}, add_in_memory(node, image, texture)};
}

ColorParam MitsubaTextures::read_scale(const MitsubaNode& node) {
  const Rgb scale = qray::find_color(node, "scale", Rgb{1.0f}, ColorUse::kEmission, import_);
  for (const MitsubaNode& child : node.children) {
    const MitsubaNode& inner = import_.document.resolve(child);
    if (inner.tag == "texture" || (is_color(inner) && child.name != "scale")) {
      const ColorParam color =
          inner.tag == "texture"
              ? read(inner)
              : ColorParam{read_mitsuba_color(inner, ColorUse::kReflectance, import_), {}};
      return {color.value * scale, color.texture};
    }
  }
  node.fail("expected a texture to scale");
}

TextureId MitsubaTextures::as_numbers(TextureId id) {
  Texture texture = import_.out.scene.textures[id.value];
  if (!texture.srgb) return id;
  texture.srgb = false;
  return add(std::move(texture));
}

TextureId MitsubaTextures::add(Texture texture) {
  std::vector<Texture>& textures = import_.out.scene.textures;
  textures.push_back(std::move(texture));
  return TextureId(static_cast<uint32_t>(textures.size() - 1));
}

TextureId MitsubaTextures::add_in_memory(const MitsubaNode& node, const Image& image,
                                         const Texture& like) {
  Result<Bytes> bytes = encode_image(ImageFormat::kExr, image);
  if (!bytes.ok()) node.fail(bytes.error().message, bytes.error().code);
  Texture texture = like;
  texture.path = node.where + ".exr";  // a name of its own
  texture.srgb = false;
  texture.bytes = std::make_shared<const Bytes>(std::move(bytes).value());
  return add(std::move(texture));
}

}  // namespace qray
