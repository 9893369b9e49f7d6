// Whole files: read with a size limit, written so that a reader or a crash sees the old bytes or
// the new ones, never a mixture (temp file, fsync, rename, fsync of the folder).
#pragma once

#include <filesystem>
#include <span>
#include <utility>

#include "core/base/byte_io.h"
#include "core/base/result.h"

namespace qray {

Result<Bytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);
// A file's bytes without a copy of them: what is not looked at takes no memory, and the system may
// take back what was. A file that is replaced meanwhile stays as it was; one that is cut must not
// be.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::filesystem::path& path, uint64_t max_bytes);
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MappedFile();
  std::span<const uint8_t> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  std::span<const uint8_t> bytes_;
};

// Makes renames and removals in the folder last. Best effort: some file systems cannot.
void sync_folder(const std::filesystem::path& folder);
Status write_file_atomic(const std::filesystem::path& path, std::span<const uint8_t> bytes);

// By its name: what a process that was killed did not get to commit.
bool is_half_written(const std::filesystem::path& path);

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
