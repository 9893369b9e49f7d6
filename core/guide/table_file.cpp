#include "core/guide/table_file.h"

#include <algorithm>

namespace qray {
namespace {

constexpr uint64_t kMagic = 0x314c425459415251;  // "QRAYTBL1"
constexpr uint32_t kEndianness = 0x01020304;
constexpr size_t kMaxString = 256, kMaxSections = 64, kTagSize = 4;
constexpr size_t kIdHexDigits = 32;

void write_digest(ByteWriter& out, const Digest& digest) { out.bytes(digest.bytes); }

Digest read_digest(ByteReader& in) {
  Digest digest;
  const auto bytes = in.bytes(digest.bytes.size());
  std::copy(bytes.begin(), bytes.end(), digest.bytes.begin());
  return digest;
}

Error corrupt(const ByteReader& in, const std::string& what) {
  return {ErrorCode::kCorrupt, what, "table, byte " + std::to_string(in.offset())};
}

Bytes encode_header(const TableHeader& header) {
  ByteWriter out;
  out.string(header.id);
  out.u32(static_cast<uint32_t>(header.parents.size()));
  for (const std::string& parent : header.parents) out.string(parent);
  out.string(header.method);
  out.string(header.program);
  write_digest(out, header.geometry);
  write_digest(out, header.materials);
  write_digest(out, header.lights);
  out.u64(header.samples_seen);
  return out.take();
}

Result<TableHeader> decode_header(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  TableHeader header;
  header.id = in.string(kMaxString);
  const uint32_t parents = in.u32();
  if (parents > kMaxTableParents) return corrupt(in, "more than 64 parents");
  for (uint32_t i = 0; i < parents && in.ok(); ++i) header.parents.push_back(in.string(kMaxString));
  header.method = in.string(kMaxString);
  header.program = in.string(kMaxString);
  header.geometry = read_digest(in);
  header.materials = read_digest(in);
  header.lights = read_digest(in);
  header.samples_seen = in.u64();
  if (!in.ok() || in.remaining() != 0)
    return corrupt(in, "the header's fields do not fit its size");
  return header;
}

}  // namespace

Bytes encode_table(const TableFile& table) {
  ByteWriter out;
  out.u64(kMagic);
  out.u32(table.header.version);
  out.u32(kEndianness);
  const Bytes header = encode_header(table.header);
  out.u32(static_cast<uint32_t>(header.size()));
  out.u32(crc32c(header));
  out.bytes(header);
  out.u32(static_cast<uint32_t>(table.sections.size()));
  for (const TableSection& section : table.sections) {
    QRAY_CHECK(section.tag.size() == kTagSize);
    for (char c : section.tag) out.u8(static_cast<uint8_t>(c));
    out.u64(section.bytes.size());
    out.u32(crc32c(section.bytes));
    out.bytes(section.bytes);
  }
  return out.take();
}

std::string table_id(TableFile table) {
  table.header.id.clear();
  const Bytes bytes = encode_table(table);
  return sha256(bytes).hex().substr(0, kIdHexDigits);
}

Result<TableFile> decode_table(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  if (in.u64() != kMagic)
    return corrupt(in, "not a qray table: its first 8 bytes are not QRAYTBL1");
  const uint32_t version = in.u32();
  if (std::ranges::find(kTableVersions, version) == kTableVersions.end()) {
    return Error{ErrorCode::kUnsupported,
                 "table format version " + std::to_string(version) + ", expected 2, 4, 7, 8 or 11",
                 "table, byte 8"};
  }
  if (in.u32() != kEndianness) return corrupt(in, "wrong endianness mark");
  const uint32_t header_size = in.u32(), header_crc = in.u32();
  const auto header_bytes = in.bytes(header_size);
  if (!in.ok()) return corrupt(in, "cut off in the header");
  if (crc32c(header_bytes) != header_crc) return corrupt(in, "the header's checksum is wrong");
  Result<TableHeader> header = decode_header(header_bytes);
  if (!header.ok()) return header.error();
  TableFile table;
  table.header = std::move(header).value();
  table.header.version = version;
  const uint32_t count = in.u32();
  if (count > kMaxSections) return corrupt(in, "more than 64 sections");
  for (uint32_t i = 0; i < count; ++i) {
    const auto tag = in.bytes(kTagSize);
    const uint64_t size = in.u64();
    const uint32_t crc = in.u32();
    if (!in.ok() || size > in.remaining())
      return corrupt(in, "cut off in section " + std::to_string(i));
    const auto body = in.bytes(size);
    if (crc32c(body) != crc) {
      return corrupt(in, "the checksum of section " + std::to_string(i) + " is wrong");
    }
    table.sections.push_back(
        {std::string(tag.begin(), tag.end()), Bytes(body.begin(), body.end())});
  }
  if (!in.ok()) return corrupt(in, "cut off before the sections");
  if (in.remaining() != 0) return corrupt(in, "bytes after the last section");
  return table;
}

std::string place_of(std::string_view tag) { return "table:" + std::string(tag); }

Status expect_sections(std::span<const TableSection> sections, std::string_view first,
                       std::string_view second) {
  if (sections.size() == 2 && sections[0].tag == first && sections[1].tag == second) return {};
  return Error{ErrorCode::kCorrupt,
               "expected the sections " + std::string(first) + " and " + std::string(second),
               "table"};
}

Error over_memory(const std::string& what, size_t max_bytes, const std::string& where) {
  return {ErrorCode::kTooLarge,
          what + " more than the " + std::to_string(max_bytes) + " bytes allowed", where};
}

}  // namespace qray
