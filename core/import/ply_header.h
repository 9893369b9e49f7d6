// The header of a PLY file. Throws ImportFailure naming the line. Any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/import/import_failure.h"

namespace qray {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

size_t ply_type_bytes(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  uint64_t min_bytes() const;  // of one in binary, its lists empty
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  size_t body_offset = 0;  // bytes
  size_t line_count = 0;
};

PlyHeader parse_ply_header(std::string_view text, const std::string& file);

}  // namespace qray
