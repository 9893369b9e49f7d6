#include "core/import/gltf_document.h"

#include <algorithm>

#include "core/base/file.h"
#include "core/import/gltf_import.h"
#include "core/import/gltf_meshopt.h"
#include "core/import/scene_folder.h"

namespace qray {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 31;  // of one file, and of all others together
constexpr uint64_t kMaxJsonBytes = uint64_t{1} << 28;  // with the data URIs in it
constexpr size_t kMaxJsonValues = 4'000'000;           // 100 bytes each
constexpr uint32_t kGlbMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

std::string percent_decoded(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
    out += low >= 0 ? static_cast<char>(high * 16 + low) : text[i];
    if (low >= 0) i += 2;
  }
  return out;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

}  // namespace

GltfDocument::GltfDocument(const std::filesystem::path& path)
    : file_(path.filename()), bytes_left_(kMaxFileBytes) {
  std::error_code ec;
  const std::filesystem::path canonical = std::filesystem::canonical(path, ec);
  if (ec) fail_import(ErrorCode::kNotFound, "no such file", file_);
  folder_ = canonical.parent_path();
  Result<Bytes> read = read_file(canonical, kMaxFileBytes);
  if (!read.ok()) fail_import(read.error().code, read.error().message, file_);
  text_ = std::move(read).value();

  std::span<const uint8_t> json = text_;
  if (ByteReader(text_).u32() == kGlbMagic) json = split_glb();
  if (json.size() > kMaxJsonBytes)
    fail_import(ErrorCode::kTooLarge, "expected at most 256 MiB of JSON", file_);
  tree_ = parse_json(json, file_, kMaxJsonValues);
  model_ = read_gltf_model(root());
  read_buffers();
  unpack_views();
}

// The JSON; sets `binary_`.
std::span<const uint8_t> GltfDocument::split_glb() {
  const auto fail = [this](size_t offset, const std::string& message) {
    fail_import(ErrorCode::kInvalid, message, file_ + ":byte " + std::to_string(offset));
  };
  ByteReader reader(text_);
  (void)reader.u32();
  const uint32_t version = reader.u32(), length = reader.u32();
  if (!reader.ok()) fail(text_.size(), "expected the 12 bytes of a GLB's header");
  if (version != 2) fail(4, "expected version 2, got " + std::to_string(version));
  if (length > text_.size())
    fail(8, "expected a file of " + std::to_string(length) + " bytes, got " +
                std::to_string(text_.size()));
  reader = ByteReader(std::span(text_).first(std::max(length, 12u)));
  (void)reader.bytes(12);

  std::span<const uint8_t> json;
  for (int chunk = 0; chunk < 2 && (chunk == 0 || reader.remaining() > 0); ++chunk) {
    const size_t offset = reader.offset();
    const uint32_t size = reader.u32(), kind = reader.u32();
    const std::span<const uint8_t> bytes = reader.bytes(size);
    if (!reader.ok()) fail(offset, "expected a chunk's header and as many bytes as it says");
    if (chunk == 0) {
      if (kind != kJsonChunk) fail(offset, "expected a chunk of JSON");
      json = bytes;
    } else if (kind == kBinaryChunk) {
      binary_ = bytes;
      has_binary_ = true;
    }
  }
  return json;
}

JsonNode GltfDocument::at(const char* list, int index) const {
  return root().get(list).at(static_cast<size_t>(index));
}

size_t GltfDocument::count(const char* list) const {
  const std::optional<JsonNode> items = root().find(list);
  return items ? items->size() : 0;
}

void GltfDocument::read_buffers() {
  for (size_t i = 0; i < count("buffers"); ++i) {
    const JsonNode node = at("buffers", static_cast<int>(i));
    const auto size =
        static_cast<size_t>(node.get("byteLength").integer(1, std::numeric_limits<int>::max()));
    const std::optional<JsonNode> uri = node.find("uri");
    std::span<const uint8_t> bytes;
    const auto packed = find_extension(node, kGltfMeshopt);
    if (packed && packed->has("fallback") && packed->get("fallback").boolean()) {
      buffers_.emplace_back();  // its views have packed bytes elsewhere
      continue;
    }
    if (!uri && i == 0 && has_binary_) {
      bytes = binary_;
    } else if (!uri) {
      node.fail("expected a \"uri\"");
    } else if (uri->string().starts_with("data:")) {
      bytes = owned_.emplace_back(read_data_uri(*uri));
    } else {
      Result<Bytes> read = read_file(find_file(*uri), bytes_left_);
      if (!read.ok()) uri->fail(read.error().message, read.error().code);
      bytes_left_ -= read.value().size();
      bytes = owned_.emplace_back(std::move(read).value());
    }
    if (bytes.size() < size)
      node.get("byteLength").fail_expected("at most " + std::to_string(bytes.size()));
    buffers_.push_back(bytes.first(size));
  }
}

std::span<const uint8_t> GltfDocument::view_bytes(int view) const {
  const GltfModel::View& v = model_.views[static_cast<size_t>(view)];
  const std::span<const uint8_t> buffer = buffers_[static_cast<size_t>(v.buffer)];
  if (v.byte_offset > buffer.size() || v.byte_length > buffer.size() - v.byte_offset) {
    at("bufferViews", view)
        .fail("expected byteOffset and byteLength within the buffer's " +
              std::to_string(buffer.size()) + " bytes");
  }
  return buffer.subspan(v.byte_offset, v.byte_length);
}

int GltfDocument::add_view(const JsonNode& place, Bytes bytes, size_t stride) {
  if (bytes.size() > bytes_left_) place.fail("unpacks to too many bytes", ErrorCode::kTooLarge);
  bytes_left_ -= bytes.size();
  const int buffer = static_cast<int>(buffers_.size());
  model_.views.push_back({buffer, 0, bytes.size(), stride});
  owned_.push_back(std::move(bytes));
  buffers_.emplace_back(owned_.back());
  return static_cast<int>(model_.views.size()) - 1;
}

void GltfDocument::unpack_views() {
  const int views = static_cast<int>(model_.views.size());
  const int buffers = static_cast<int>(buffers_.size());
  for (int i = 0; i < views; ++i) {
    const auto extension = find_extension(at("bufferViews", i), kGltfMeshopt);
    if (!extension) continue;
    const GltfPacked packed = read_gltf_packed(*extension, buffers);
    const std::span<const uint8_t> buffer = buffers_[static_cast<size_t>(packed.buffer)];
    if (packed.byte_offset > buffer.size() ||
        packed.byte_length > buffer.size() - packed.byte_offset)
      extension->fail("expected byteOffset and byteLength within the buffer's " +
                      std::to_string(buffer.size()) + " bytes");
    if (packed.size() > bytes_left_)
      extension->fail("unpacks to too many bytes", ErrorCode::kTooLarge);
    const size_t stride = model_.views[static_cast<size_t>(i)].byte_stride;
    const int made = add_view(
        *extension,
        unpack_gltf(*extension, packed, buffer.subspan(packed.byte_offset, packed.byte_length)),
        stride);
    model_.views[static_cast<size_t>(i)] = model_.views[static_cast<size_t>(made)];
  }
}

GltfDocument::Picture GltfDocument::read_picture(int image) {
  if (const auto it = pictures_.find(image); it != pictures_.end()) return it->second;
  const JsonNode node = at("images", image);
  Picture picture;
  if (const std::optional<JsonNode> uri = node.find("uri")) {
    if (uri->string().starts_with("data:"))
      picture.bytes = std::make_shared<const Bytes>(read_data_uri(*uri));
    else
      picture.path = find_file(*uri);
  } else {
    const int view = model_.images[static_cast<size_t>(image)].view;
    if (view < 0) node.fail("expected a \"uri\" or a \"bufferView\"");
    const std::span<const uint8_t> bytes = view_bytes(view);
    // Any number of pictures may lie over each other in a buffer.
    if (bytes.size() > bytes_left_) node.fail("pictures of too many bytes", ErrorCode::kTooLarge);
    bytes_left_ -= bytes.size();
    picture.bytes = std::make_shared<const Bytes>(bytes.begin(), bytes.end());
  }
  if (picture.bytes) picture.path = node.place();
  pictures_.emplace(image, picture);
  return picture;
}

// data:[<kind>];base64,<digits>
Bytes GltfDocument::read_data_uri(const JsonNode& uri) const {
  const std::string& text = uri.string();
  const size_t comma = text.find(',');
  if (comma == std::string::npos || !std::string_view(text).substr(0, comma).ends_with(";base64"))
    uri.fail("expected \"data:...;base64,\" and base64");
  std::string_view digits = std::string_view(text).substr(comma + 1);
  while (digits.ends_with('=')) digits.remove_suffix(1);
  Bytes out;
  out.reserve(digits.size() * 3 / 4);
  uint32_t bits = 0;
  for (size_t i = 0; i < digits.size(); ++i) {
    const int digit = base64_digit(digits[i]);
    if (digit < 0) uri.fail("expected base64 at character " + std::to_string(comma + 1 + i));
    bits = bits << 6 | static_cast<uint32_t>(digit);
    if (i % 4 != 0) out.push_back(static_cast<uint8_t>(bits >> (6 - 2 * (i % 4))));
  }
  return out;
}

std::filesystem::path GltfDocument::find_file(const JsonNode& uri) const {
  const std::string name = percent_decoded(uri.string());
  if (name.find('\0') != std::string::npos) uri.fail("expected a file's name without a 0 byte");
  const Result<std::filesystem::path> path = find_within(folder_, folder_, name);
  if (!path.ok()) uri.fail(path.error().message, path.error().code);
  return path.value();
}

}  // namespace qray
