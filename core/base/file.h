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

// The same, for files that are written piece by piece. What was not committed leaves no trace.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const uint8_t> bytes);  // an error is kept for commit()
  Status commit();                             // once

 private:
  void fail(const char* doing);

  std::filesystem::path path_, temp_;
  int fd_ = -1;
  Bytes waiting_;  // small writes, gathered
  Status status_;
};

}  // namespace qray
