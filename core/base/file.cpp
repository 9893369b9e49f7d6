#include "core/base/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/process_name.h"

namespace qray {
namespace {

constexpr const char* kTemporary = ".tmp.";

Error io_error(const std::filesystem::path& path, const char* doing) {
  return {ErrorCode::kIo, std::string(doing) + ": " + std::strerror(errno), path.string()};
}

bool write_all(int fd, std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return true;
}

Result<int> open_for_reading(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd >= 0) return fd;
  Error error = io_error(path, "cannot read");
  if (errno == ENOENT) error.code = ErrorCode::kNotFound;
  return error;
}

Result<uint64_t> size_of(int fd, const std::filesystem::path& path, uint64_t max_bytes) {
  struct stat info;
  if (::fstat(fd, &info) != 0) return io_error(path, "cannot read");
  if (!S_ISREG(info.st_mode)) return Error{ErrorCode::kIo, "expected a file", path.string()};
  const uint64_t size = static_cast<uint64_t>(info.st_size);
  if (size > max_bytes) {
    return Error{
        ErrorCode::kTooLarge,
        "has " + std::to_string(size) + " bytes, expected at most " + std::to_string(max_bytes),
        path.string()};
  }
  return size;
}

Result<Bytes> read_open(int fd, const std::filesystem::path& path, uint64_t max_bytes) {
  const Result<uint64_t> size = size_of(fd, path, max_bytes);
  if (!size.ok()) return size.error();
  Bytes bytes(size.value());
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::read(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error(path, "cannot read");
    if (n == 0) return Error{ErrorCode::kIo, "shrank while it was read", path.string()};
    done += static_cast<size_t>(n);
  }
  return bytes;
}

}  // namespace

Result<Bytes> read_file(const std::filesystem::path& path, uint64_t max_bytes) {
  // One descriptor for size and bytes, so that a replacement in between changes neither.
  const Result<int> fd = open_for_reading(path);
  if (!fd.ok()) return fd.error();
  const Result<Bytes> result = read_open(fd.value(), path, max_bytes);
  ::close(fd.value());
  return result;
}

Result<MappedFile> MappedFile::open(const std::filesystem::path& path, uint64_t max_bytes) {
  const Result<int> fd = open_for_reading(path);
  if (!fd.ok()) return fd.error();
  const Result<uint64_t> size = size_of(fd.value(), path, max_bytes);
  void* at = nullptr;
  if (size.ok() && size.value() > 0)
    at = ::mmap(nullptr, size.value(), PROT_READ, MAP_PRIVATE, fd.value(), 0);
  const Error failed = io_error(path, "cannot read");
  ::close(fd.value());
  if (!size.ok()) return size.error();
  if (at == MAP_FAILED) return failed;
  return MappedFile({static_cast<const uint8_t*>(at), size.value()});
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<uint8_t*>(bytes_.data()), bytes_.size());
}

void sync_folder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

bool is_half_written(const std::filesystem::path& path) {
  return path.filename().string().find(kTemporary) != std::string::npos;
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), temp_(path_) {
  static std::atomic<uint64_t> counter{0};
  temp_ += kTemporary + process_name() + "." + std::to_string(counter++);
  fd_ = ::open(temp_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd_ < 0) status_ = io_error(temp_, "cannot create");
}

AtomicFile::~AtomicFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  ::unlink(temp_.c_str());
}

void AtomicFile::fail(const char* doing) {
  if (status_.ok()) status_ = io_error(temp_, doing);
}

void AtomicFile::write(std::span<const uint8_t> bytes) {
  constexpr size_t kGather = 1 << 16;
  if (!status_.ok()) return;
  if (bytes.size() < kGather) {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    if (waiting_.size() < kGather) return;
    bytes = {};
  }
  if (!write_all(fd_, waiting_) || !write_all(fd_, bytes)) fail("cannot write");
  waiting_.clear();
}

Status AtomicFile::commit() {
  if (status_.ok() && (!write_all(fd_, waiting_) || ::fsync(fd_) != 0)) fail("cannot write");
  if (!status_.ok()) return status_;
  if (::rename(temp_.c_str(), path_.c_str()) != 0) return io_error(path_, "cannot rename onto");
  ::close(std::exchange(fd_, -1));
  sync_folder(path_.has_parent_path() ? path_.parent_path() : ".");
  return {};
}

Status write_file_atomic(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
  AtomicFile file(path);
  file.write(bytes);
  return file.commit();
}

}  // namespace qray
