#include "server/store/asset_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "core/base/file.h"
#include "core/base/process_name.h"
#include "server/store/folder_watch.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPart = ".part";

Error io_error(const std::string& doing, const fs::path& path) {
  return {ErrorCode::kIo, doing + ": " + std::strerror(errno), path.string()};
}

}  // namespace

bool is_asset_name(std::string_view name) {
  return name.size() == 64 && name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

Result<std::unique_ptr<AssetStore>> AssetStore::open(const fs::path& data, DiskQuota& quota,
                                                     std::chrono::seconds left) {
  std::unique_ptr<AssetStore> store(new AssetStore(data / "assets", quota));
  std::error_code ec;
  fs::create_directories(store->folder_, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), store->folder_.string()};
  for (fs::directory_iterator it(store->folder_, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code failed;
    if (it->path().extension() == kPart) {
      if (is_older(it->path(), left)) fs::remove(it->path(), failed);
    } else if (is_asset_name(it->path().filename().string())) {
      const uint64_t size = it->file_size(failed);
      if (!failed) quota.note(DiskQuota::on_disk(size));
    }
    if (failed) return Error{ErrorCode::kIo, failed.message(), it->path().string()};
  }
  if (ec) return Error{ErrorCode::kIo, ec.message(), store->folder_.string()};
  store->remove_unused();
  return store;
}

bool AssetStore::has(const std::string& name) {
  std::lock_guard lock(mutex_);
  return is_asset_name(name) &&
         ::utimensat(AT_FDCWD, (folder_ / name).c_str(), nullptr, AT_SYMLINK_NOFOLLOW) == 0;
}

Result<AssetStore::Upload> AssetStore::begin(const std::string& name, uint64_t size) {
  const auto take = [&] { return size <= quota_.bytes() && quota_.take(DiskQuota::on_disk(size)); };
  if (!take()) {
    remove_unused();
    if (!take()) {
      return Error{ErrorCode::kTooLarge,
                   std::to_string(quota_.used()) + " of " + std::to_string(quota_.bytes()) +
                       " bytes for uploads are taken: delete scenes that are not needed",
                   ""};
    }
  }
  Upload upload(*this, name, size);
  upload.fd_ = ::open(upload.file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0444);
  if (upload.fd_ < 0) return io_error("cannot create", upload.file_);
  return upload;
}

Status AssetStore::link(const std::string& name, const fs::path& to) const {
  if (::link((folder_ / name).c_str(), to.c_str()) == 0) return {};
  Error error = io_error("cannot link", to);
  if (errno == ENOENT) error.code = ErrorCode::kNotFound;
  return error;
}

void AssetStore::remove_unused(std::chrono::seconds older_than) {
  std::lock_guard lock(mutex_);
  const std::time_t before =
      std::chrono::system_clock::to_time_t(std::chrono::system_clock::now() - older_than);
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec)) {
    if (!is_asset_name(it->path().filename().string())) continue;
    struct stat info;
    if (::stat(it->path().c_str(), &info) != 0 || info.st_nlink > 1) continue;
    if (info.st_mtim.tv_sec > before || ::unlink(it->path().c_str()) != 0) continue;
    quota_.give_back(DiskQuota::on_disk(static_cast<uint64_t>(info.st_size)));
  }
}

AssetStore::Upload::Upload(AssetStore& store, std::string name, uint64_t size)
    : store_(&store), name_(std::move(name)), size_(size), left_(size) {
  static std::atomic<uint64_t> counter{0};
  file_ = store.folder_ / (name_ + "." + process_name() + "." + std::to_string(counter++) + kPart);
}

AssetStore::Upload::Upload(Upload&& other) noexcept
    : store_(std::exchange(other.store_, nullptr)),
      name_(std::move(other.name_)),
      file_(std::move(other.file_)),
      fd_(std::exchange(other.fd_, -1)),
      size_(other.size_),
      left_(other.left_),
      hash_(std::move(other.hash_)) {}

AssetStore::Upload::~Upload() {
  if (!store_) return;  // moved from, or committed
  if (fd_ >= 0) {
    ::close(fd_);
    ::unlink(file_.c_str());
  }
  store_->quota_.give_back(DiskQuota::on_disk(size_));
}

Status AssetStore::Upload::add(std::span<const uint8_t> bytes) {
  if (bytes.size() > left_)
    return Error{ErrorCode::kTooLarge, "more bytes than Content-Length says", ""};
  left_ -= bytes.size();
  hash_->add(bytes);
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return io_error("cannot write", file_);
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return {};
}

Status AssetStore::Upload::commit() {
  const std::string got = hash_->finish().hex();
  if (got != name_) {
    return Error{ErrorCode::kInvalid,
                 "the body's SHA-256 is " + got + ", expected " + name_ + " as the address says",
                 ""};
  }
  if (::fsync(fd_) != 0) return io_error("cannot write", file_);
  std::unique_lock lock(store_->mutex_);
  const fs::path to = store_->folder_ / name_;
  std::error_code ec;
  if (fs::exists(to, ec)) return {};  // another upload of the same bytes was first
  if (::rename(file_.c_str(), to.c_str()) != 0) return io_error("cannot rename onto", to);
  ::close(std::exchange(fd_, -1));
  sync_folder(store_->folder_);
  lock.unlock();
  store_ = nullptr;  // the bytes stay taken
  return {};
}

}  // namespace qray::server
