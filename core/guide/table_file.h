// A table on disk: proto/table_file.md is the format. This file owns bytes; where tables live and
// which one a job gets is the table store's. Explicitly encoded, little-endian, CRC-32C per
// section.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/base/sha256.h"

namespace qray {

// What is written, and what is read: two bits apart, since nothing else would tell a flipped one.
constexpr uint32_t kTableFormatVersion = 11;
constexpr std::array<uint32_t, 5> kTableVersions{2, 4, 7, 8, kTableFormatVersion};
constexpr size_t kMaxTableParents = 64;
constexpr int kMaxTableExponent = 100;  // of a grid's cells or a cube, in metres, both ways

struct TableHeader {
  uint32_t version = kTableFormatVersion;  // of the file
  std::string id;                          // 32 hex digits: table_id()
  std::vector<std::string> parents;        // ids of the tables it grew from
  std::string method;                      // "huang"
  std::string program;                     // version that wrote it
  Digest geometry, materials, lights;
  uint64_t samples_seen = 0;
};

struct TableSection {
  std::string tag;  // 4 characters
  Bytes bytes;
};

struct TableFile {
  TableHeader header;
  std::vector<TableSection> sections;
};

Bytes encode_table(const TableFile& table);
// A hash of what it holds but its id, so the same job makes the same table.
std::string table_id(TableFile table);
// Checks magic, version, sizes (before allocating) and checksums. Errors are kCorrupt or
// kUnsupported with the byte offset.
Result<TableFile> decode_table(std::span<const uint8_t> bytes);

// Where an error in a section is: "table:ACUB".
std::string place_of(std::string_view tag);
// kCorrupt unless the sections are these two.
Status expect_sections(std::span<const TableSection> sections, std::string_view first,
                       std::string_view second);
// kTooLarge. `what`: "the table needs".
Error over_memory(const std::string& what, size_t max_bytes, const std::string& where);

}  // namespace qray
