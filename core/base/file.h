// Whole files: read with a size limit, written so that a reader or a crash sees the old bytes or
// the new ones, never a mixture (temp file, fsync, rename, fsync of the folder).
#pragma once

#include <filesystem>
#include <span>

#include "core/base/byte_io.h"
#include "core/base/result.h"

namespace qray {

Result<Bytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);
// Makes renames and removals in the folder last. Best effort: some file systems cannot.
void sync_folder(const std::filesystem::path& folder);
Status write_file_atomic(const std::filesystem::path& path, std::span<const uint8_t> bytes);

}  // namespace qray
