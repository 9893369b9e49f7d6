#include "server/store/result_store.h"

#include <algorithm>
#include <fstream>

#include "core/base/file.h"

namespace qray::server {
namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;
constexpr const char* kFramesFile = "frames.json";
constexpr const char* kCanceledFramesFile = "frames-canceled.txt";  // a number a line
constexpr uint64_t kMaxFramesBytes = 64u << 20;

// What was written here and cannot be read any more is nobody's fault who asks for it.
template <class T>
Result<T> kept(Result<T> loaded) {
  if (loaded.ok() || loaded.error().code == ErrorCode::kNotFound ||
      loaded.error().code == ErrorCode::kIo)
    return loaded;
  return Error{ErrorCode::kCorrupt, loaded.error().message, loaded.error().where};
}

std::filesystem::file_time_type written_at(const std::filesystem::path& file) {
  std::error_code ec;
  return std::filesystem::last_write_time(file, ec);
}

// By another server, after it was read here.
bool is_written_anew(const std::filesystem::path& file, std::filesystem::file_time_type read) {
  std::error_code ec;
  const auto now = std::filesystem::last_write_time(file, ec);
  return !ec && now != read;
}

}  // namespace

Status ResultStore::save(const PictureKey& key, const Film& film, const ImageMetadata& metadata) {
  auto picture = std::make_shared<const Picture>(take_picture(film));
  if (Status s = save_picture(folder(key), *picture, metadata); !s.ok()) return s;
  remember(key, std::move(picture));
  if (const std::shared_ptr<const Image> noise = film.noise())
    return write_image(noise_file(key), *noise, {});
  return {};
}

Result<Image> ResultStore::load_noise(const PictureKey& key) const {
  return kept(read_image(noise_file(key), kMaxPicturePixels));
}

Result<Image> ResultStore::load_noise_row(const PictureKey& key, int y) const {
  return kept(read_image_row(noise_file(key), y));
}

Status ResultStore::save_recovered(const PictureKey& key, const Image& recovered,
                                   const ImageMetadata& metadata) {
  const std::filesystem::path file = recovered_file(key);
  std::error_code ec;
  std::filesystem::create_directories(file.parent_path(), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file.parent_path().string()};
  return write_image(file, recovered, metadata);
}

Status ResultStore::save_passes(const PictureKey& key, const LayeredPicture& passes) {
  const std::filesystem::path file = passes_file(key);
  std::error_code ec;
  std::filesystem::create_directories(file.parent_path(), ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), file.parent_path().string()};
  for (size_t g = 0; g < passes.groups; ++g)
    if (Status s = write_image(group_file(key, g), passes.layers[passes.first_group + g].image);
        !s.ok())
      return s;
  return write_layers(file, passes.layers, passes.metadata);
}

Result<Image> ResultStore::load_light_group(const PictureKey& key, size_t group) const {
  return kept(read_image(group_file(key, group), kMaxPicturePixels));
}

bool ResultStore::has_recovered(const PictureKey& key) const {
  std::error_code ec;
  return std::filesystem::exists(recovered_file(key), ec);
}

Result<Image> ResultStore::load_recovered(const PictureKey& key) const {
  return kept(read_image(recovered_file(key), kMaxPicturePixels));
}

Result<Image> ResultStore::load_recovered_row(const PictureKey& key, int y) const {
  return kept(read_image_row(recovered_file(key), y));
}

Result<Bytes> ResultStore::load_file(const PictureKey& key, bool recovered, int height) const {
  const std::filesystem::path file = recovered ? recovered_file(key) : image_file(key);
  Result<Bytes> bytes = read_file(file, kMaxImageBytes);
  if (!bytes.ok()) return bytes;
  // The rows lie in their order: of a file that is cut off the last one is missing.
  const Result<Image> last = kept(read_image_row(file, height - 1));
  if (!last.ok()) return last.error();
  return bytes;
}

Result<std::shared_ptr<const Picture>> ResultStore::load(const PictureKey& key) {
  {
    std::lock_guard lock(mutex_);
    const auto found = std::find_if(recent_.begin(), recent_.end(),
                                    [&](const auto& entry) { return entry.key == key; });
    if (found != recent_.end() && !is_written_anew(image_file(key), found->written)) {
      recent_.splice(recent_.begin(), recent_, found);
      return recent_.front().picture;
    }
  }
  Result<Picture> loaded = kept(load_picture(folder(key)));
  if (!loaded.ok()) return loaded.error();
  auto picture = std::make_shared<const Picture>(std::move(loaded).value());
  remember(key, picture);
  return picture;
}

void ResultStore::remove(JobId id) {
  std::lock_guard lock(mutex_);
  std::erase_if(recent_, [&](const auto& entry) { return entry.key.job == id; });
  std::error_code ec;
  std::filesystem::remove_all(folder_ / id.text(), ec);
}

void ResultStore::remove_half_written(JobId id) {
  std::vector<std::filesystem::path> found;
  std::error_code ec;
  for (std::filesystem::recursive_directory_iterator it(folder_ / id.text(), ec), end;
       !ec && it != end; it.increment(ec))
    if (is_half_written(it->path())) found.push_back(it->path());
  for (const std::filesystem::path& path : found) std::filesystem::remove(path, ec);
}

Status ResultStore::save_frames(JobId id, std::string_view json) {
  const std::filesystem::path folder = this->folder(id);
  std::error_code ec;
  std::filesystem::create_directories(folder, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), folder.string()};
  return write_file_atomic(folder / kFramesFile,
                           {reinterpret_cast<const uint8_t*>(json.data()), json.size()});
}

Result<std::string> ResultStore::load_frames(JobId id) const {
  const Result<Bytes> bytes = read_file(folder(id) / kFramesFile, kMaxFramesBytes);
  if (!bytes.ok()) return bytes.error();
  return std::string(bytes.value().begin(), bytes.value().end());
}

Status ResultStore::save_canceled_frames(JobId id, const std::set<int>& frames) {
  const std::filesystem::path folder = this->folder(id);
  std::error_code ec;
  std::filesystem::create_directories(folder, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), folder.string()};
  std::string text;
  for (const int frame : frames) text += std::to_string(frame) + "\n";
  return write_file_atomic(folder / kCanceledFramesFile,
                           {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::set<int> ResultStore::canceled_frames(JobId id) const {
  std::ifstream in(folder(id) / kCanceledFramesFile);
  std::set<int> frames;
  for (int frame; in >> frame;) frames.insert(frame);
  return frames;
}

std::filesystem::file_time_type ResultStore::canceled_frames_at(JobId id) const {
  std::error_code ec;
  const auto at = std::filesystem::last_write_time(folder(id) / kCanceledFramesFile, ec);
  return ec ? std::filesystem::file_time_type() : at;
}

void ResultStore::remember(const PictureKey& key, std::shared_ptr<const Picture> picture) {
  std::lock_guard lock(mutex_);
  std::erase_if(recent_, [&](const auto& entry) { return entry.key == key; });
  recent_.push_front({key, std::move(picture), written_at(image_file(key))});
  size_t bytes = 0, kept = 0;
  for (const auto& entry : recent_) {
    bytes += entry.picture->bytes();
    if (kept > 0 && bytes > cache_bytes_) break;
    ++kept;
  }
  recent_.erase(std::next(recent_.begin(), static_cast<std::ptrdiff_t>(kept)), recent_.end());
}

}  // namespace qray::server
