#include "server/imports/unzip.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "core/base/file_names.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr zip_int64_t kMaxEntries = 2 * FileNames::kMost;  // folders are entries too

struct CloseFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
struct CloseArchive {
  void operator()(zip_t* zip) const { zip_discard(zip); }
};

class Output {
 public:
  explicit Output(const fs::path& path)
      : fd_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0444)) {}
  ~Output() {
    if (fd_ >= 0) ::close(fd_);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  bool write(const char* data, size_t size) const {
    while (size > 0) {
      const ssize_t n = ::write(fd_, data, size);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      data += n;
      size -= static_cast<size_t>(n);
    }
    return true;
  }

 private:
  int fd_;
};

class Unpacker {
 public:
  Unpacker(zip_t* zip, const fs::path& folder, uint64_t max_bytes)
      : zip_(zip), folder_(folder), max_bytes_(max_bytes) {}

  Result<Unzipped> run() {
    const zip_int64_t count = zip_get_num_entries(zip_, 0);
    if (count > kMaxEntries)
      return Error{ErrorCode::kTooLarge,
                   "expected at most " + std::to_string(kMaxEntries) + " entries, got " +
                       std::to_string(count),
                   ""};
    // All names and sizes first: a bad archive is refused before anything is written.
    for (zip_int64_t i = 0; i < count; ++i)
      if (Status s = look_at(static_cast<zip_uint64_t>(i)); !s.ok()) return s.error();
    Unzipped out;
    for (const Entry& entry : entries_) {
      if (Status s = unpack(entry, out.bytes); !s.ok()) return s.error();
      out.names.push_back(entry.name);
    }
    return out;
  }

 private:
  struct Entry {
    zip_uint64_t index, size;
    std::string name;
  };

  Error fault(const std::string& name, std::string message) const {
    return {ErrorCode::kInvalid, std::move(message), name};
  }
  Error too_large(const std::string& name) const {
    return {ErrorCode::kTooLarge,
            "the archive's files take more than " + std::to_string(max_bytes_) + " bytes", name};
  }

  Status look_at(zip_uint64_t index) {
    zip_stat_t info;
    // Raw: libzip's guess at an old encoding may turn a good name into a bad one.
    if (zip_stat_index(zip_, index, ZIP_FL_ENC_RAW, &info) != 0 || !(info.valid & ZIP_STAT_NAME))
      return fault("entry " + std::to_string(index), zip_strerror(zip_));
    std::string name = info.name;
    const bool is_folder = name.ends_with('/');
    if (is_folder) name.pop_back();
    FileNames alone;
    if (const auto wrong = (is_folder ? alone : names_).add(name)) return fault(name, *wrong);
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    zip_file_get_external_attributes(zip_, index, 0, &system, &attributes);
    const mode_t kind = (attributes >> 16) & S_IFMT;
    if (system == ZIP_OPSYS_UNIX && kind != 0 && kind != (is_folder ? S_IFDIR : S_IFREG))
      return fault(name, "expected a file or a folder, got a link or something else");
    if (is_folder) return {};
    if (info.encryption_method != ZIP_EM_NONE) return fault(name, "is encrypted");
    if (!(info.valid & ZIP_STAT_SIZE)) return fault(name, "its size is not given");
    if (info.size > max_bytes_ - announced_) return too_large(name);
    announced_ += info.size;
    entries_.push_back({index, info.size, std::move(name)});
    return {};
  }

  Status unpack(const Entry& entry, uint64_t& bytes) {
    const fs::path path = folder_ / entry.name;
    std::error_code ec;
    fs::create_directories(path.parent_path(), ec);
    const Output out(path);
    const std::unique_ptr<zip_file_t, CloseFile> in(zip_fopen_index(zip_, entry.index, 0));
    if (!in) return fault(entry.name, zip_strerror(zip_));
    char block[64 * 1024];
    uint64_t left = entry.size;
    for (zip_int64_t n; (n = zip_fread(in.get(), block, sizeof block)) != 0;) {
      if (n < 0) return fault(entry.name, zip_file_strerror(in.get()));
      if (static_cast<uint64_t>(n) > left)
        return fault(entry.name, "holds more than the " + std::to_string(entry.size) +
                                     " bytes that the archive says");
      left -= static_cast<uint64_t>(n);
      bytes += static_cast<uint64_t>(n);
      if (!out.write(block, static_cast<size_t>(n)))
        return Error{ErrorCode::kIo, std::string("cannot be unpacked: ") + std::strerror(errno),
                     entry.name};
    }
    if (left > 0)
      return fault(entry.name, "ends " + std::to_string(left) + " bytes before the archive says");
    return {};
  }

  zip_t* zip_;
  const fs::path& folder_;
  uint64_t max_bytes_, announced_ = 0;
  FileNames names_;
  std::vector<Entry> entries_;
};

}  // namespace

Result<Unzipped> unzip(const fs::path& archive, const fs::path& folder, uint64_t max_bytes) {
  int error = 0;
  const std::unique_ptr<zip_t, CloseArchive> zip(
      zip_open(archive.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &error));
  if (!zip) {
    zip_error_t text;
    zip_error_init_with_code(&text, error);
    Error no_zip{ErrorCode::kInvalid,
                 std::string("not a zip archive: ") + zip_error_strerror(&text), ""};
    zip_error_fini(&text);
    return no_zip;
  }
  return Unpacker(zip.get(), folder, max_bytes).run();
}

}  // namespace qray::server
