#include "server/store/result_store.h"

#include <algorithm>

namespace qray::server {
Status ResultStore::save(JobId id, const Film& film, const ImageMetadata& metadata) {
  auto picture = std::make_shared<const Picture>(take_picture(film));
  if (Status s = save_picture(folder_ / id.text(), *picture, metadata); !s.ok()) return s;
  remember(id, std::move(picture));
  if (const std::shared_ptr<const Image> noise = film.noise())
    return write_image(noise_file(id), *noise, {});
  return {};
}

Result<Image> ResultStore::load_noise(JobId id) const {
  return read_image(noise_file(id), kMaxPicturePixels);
}

Result<Image> ResultStore::load_noise_row(JobId id, int y) const {
  return read_image_row(noise_file(id), y);
}

Status ResultStore::save_recovered(JobId id, const Image& recovered,
                                   const ImageMetadata& metadata) {
  const std::filesystem::path file = recovered_file(id);
  std::error_code ec;
  std::filesystem::create_directories(file.parent_path(), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file.parent_path().string()};
  return write_image(file, recovered, metadata);
}

Result<Image> ResultStore::load_recovered(JobId id) const {
  return read_image(recovered_file(id), kMaxPicturePixels);
}

Result<Image> ResultStore::load_recovered_row(JobId id, int y) const {
  return read_image_row(recovered_file(id), y);
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
  Result<Picture> loaded = load_picture(folder_ / id.text());
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
