#include "server/store/result_store.h"

#include <algorithm>

#include "core/base/file.h"

namespace qray::server {
namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;

// What was written here and cannot be read any more is nobody's fault who asks for it.
template <class T>
Result<T> kept(Result<T> loaded) {
  if (loaded.ok() || loaded.error().code == ErrorCode::kNotFound ||
      loaded.error().code == ErrorCode::kIo)
    return loaded;
  return Error{ErrorCode::kCorrupt, loaded.error().message, loaded.error().where};
}

}  // namespace

Status ResultStore::save(JobId id, const Film& film, const ImageMetadata& metadata) {
  auto picture = std::make_shared<const Picture>(take_picture(film));
  if (Status s = save_picture(folder_ / id.text(), *picture, metadata); !s.ok()) return s;
  remember(id, std::move(picture));
  if (const std::shared_ptr<const Image> noise = film.noise())
    return write_image(noise_file(id), *noise, {});
  return {};
}

Result<Image> ResultStore::load_noise(JobId id) const {
  return kept(read_image(noise_file(id), kMaxPicturePixels));
}

Result<Image> ResultStore::load_noise_row(JobId id, int y) const {
  return kept(read_image_row(noise_file(id), y));
}

Status ResultStore::save_recovered(JobId id, const Image& recovered,
                                   const ImageMetadata& metadata) {
  const std::filesystem::path file = recovered_file(id);
  std::error_code ec;
  std::filesystem::create_directories(file.parent_path(), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file.parent_path().string()};
  return write_image(file, recovered, metadata);
}

bool ResultStore::has_recovered(JobId id) const {
  std::error_code ec;
  return std::filesystem::exists(recovered_file(id), ec);
}

Result<Image> ResultStore::load_recovered(JobId id) const {
  return kept(read_image(recovered_file(id), kMaxPicturePixels));
}

Result<Image> ResultStore::load_recovered_row(JobId id, int y) const {
  return kept(read_image_row(recovered_file(id), y));
}

Result<Bytes> ResultStore::load_file(JobId id, bool recovered, int height) const {
  const std::filesystem::path file = recovered ? recovered_file(id) : image_file(id);
  Result<Bytes> bytes = read_file(file, kMaxImageBytes);
  if (!bytes.ok()) return bytes;
  // The rows lie in their order: of a file that is cut off the last one is missing.
  const Result<Image> last = kept(read_image_row(file, height - 1));
  if (!last.ok()) return last.error();
  return bytes;
}

Result<std::shared_ptr<const Picture>> ResultStore::load(JobId id) {
  {
    std::lock_guard lock(mutex_);
    const auto found = std::find_if(recent_.begin(), recent_.end(),
                                    [&](const auto& entry) { return entry.first == id; });
    if (found != recent_.end()) {
      recent_.splice(recent_.begin(), recent_, found);
      return recent_.front().second;
    }
  }
  Result<Picture> loaded = kept(load_picture(folder_ / id.text()));
  if (!loaded.ok()) return loaded.error();
  auto picture = std::make_shared<const Picture>(std::move(loaded).value());
  remember(id, picture);
  return picture;
}

void ResultStore::remove(JobId id) {
  std::lock_guard lock(mutex_);
  std::erase_if(recent_, [&](const auto& entry) { return entry.first == id; });
  std::error_code ec;
  std::filesystem::remove_all(folder_ / id.text(), ec);
}

void ResultStore::remember(JobId id, std::shared_ptr<const Picture> picture) {
  std::lock_guard lock(mutex_);
  std::erase_if(recent_, [&](const auto& entry) { return entry.first == id; });
  recent_.emplace_front(id, std::move(picture));
  size_t bytes = 0, kept = 0;
  for (const auto& entry : recent_) {
    bytes += entry.second->bytes();
    if (kept > 0 && bytes > cache_bytes_) break;
    ++kept;
  }
  recent_.resize(kept);
}

}  // namespace qray::server
