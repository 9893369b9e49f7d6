// The rows of a picture's file one after the other, from the top, so that a large one need not be
// in memory as a whole. One thread.
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "core/base/byte_io.h"
#include "core/base/result.h"

namespace qray {

struct PictureInfo {
  int width = 0, height = 0;
  int channels = 0;        // that are read: at most 4
  int alpha_channel = -1;  // of these; -1: none
  bool is_8_bit = false;
};

// `path` is read, or `bytes` (null: none) where the picture lies in memory and `path` is its name.
// Errors name the path.
Result<PictureInfo> read_picture_info(const std::filesystem::path& path, const Bytes* bytes);

// Calls `row` with every row's values as they are stored, 8 bits as 0..255, alpha not multiplied.
// Rows from `row_limit` on are not read.
Status read_picture_rows(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                         const std::function<void(std::span<const float>)>& row);

// The same of a picture of 8 bits.
Status read_picture_bytes(const std::filesystem::path& path, const Bytes* bytes, int row_limit,
                          const std::function<void(std::span<const uint8_t>)>& row);

}  // namespace qray
