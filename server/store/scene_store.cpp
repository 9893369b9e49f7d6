#include "server/store/scene_store.h"

#include <algorithm>

#include "core/import/resolve_scene.h"
#include "core/math/hash.h"

namespace qray::server {
namespace fs = std::filesystem;

Result<fs::path> SceneStore::file_of(std::string_view name) const {
  if (!uploads_ || !UploadedScenes::is_name(name)) return resolve_scene_name(name, folder_);
  if (std::optional<fs::path> file = uploads_->file(name)) return *file;
  return Error{ErrorCode::kNotFound, "no scene of this name", std::string(name)};
}

bool SceneStore::has(std::string_view name) const { return file_of(name).ok(); }

SceneStore::Stamp SceneStore::stamp(const std::string& name) const {
  constexpr int kMaxFiles = 10'000;
  Stamp sum = 0;  // in any order
  std::error_code ec;
  int seen = 0;
  for (fs::recursive_directory_iterator it(folder_ / name, ec), end; !ec && it != end;
       it.increment(ec)) {
    std::error_code missing;
    uint64_t file = std::hash<std::string>()(it->path().string());
    file = hash_combine(
        file, static_cast<uint64_t>(it->last_write_time(missing).time_since_epoch().count()));
    if (it->is_regular_file(missing)) file = hash_combine(file, it->file_size(missing));
    sum += file;
    if (++seen >= kMaxFiles) break;
  }
  return sum;
}

std::vector<proto::SceneInfo> SceneStore::list() {
  std::vector<std::string> names;
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec)) {
    std::string name = it->path().filename().string();
    if (has(name)) names.push_back(std::move(name));
  }
  std::vector<proto::SceneInfo> scenes;
  if (uploads_) scenes = uploads_->list();
  for (std::string& name : names) {
    const auto wh = size(name);
    proto::SceneInfo info{std::move(name), {}, {}, false};
    if (wh) {
      info.width = wh->first;
      info.height = wh->second;
    }
    scenes.push_back(std::move(info));
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return scenes;
}

void SceneStore::Known::take(const Scene& scene) {
  size = {scene.width, scene.height};
  for (const NamedCamera& own : scene.cameras) cameras.push_back(own.name);
}

std::vector<std::string> SceneStore::cameras(const std::string& name) {
  if (!size(name)) return {};  // knows it then
  if (uploads_)
    if (const auto report = uploads_->find(name)) return report->cameras;
  std::lock_guard lock(mutex_);
  const auto found = known_.find(name);
  return found == known_.end() ? std::vector<std::string>() : found->second.cameras;
}

std::optional<std::pair<int, int>> SceneStore::size(const std::string& name) {
  Result<fs::path> path = file_of(name);
  if (!path.ok()) return std::nullopt;
  if (uploads_)
    if (const auto report = uploads_->find(name)) return std::pair(report->width, report->height);
  const Stamp stamp = this->stamp(name);
  {
    std::lock_guard lock(mutex_);
    const auto found = known_.find(name);
    if (found != known_.end() && found->second.stamp == stamp) return found->second.size;
  }
  Known known{stamp, {}, {}};
  if (Result<LoadedScene> loaded = load_scene(path.value(), {limits_, false, {}, {}}); loaded.ok())
    known.take(loaded.value().scene);
  std::lock_guard lock(mutex_);
  known_[name] = known;
  return known.size;
}

Result<std::shared_ptr<const PreparedScene>> SceneStore::prepare(const std::string& name,
                                                                 const LoadWatch& watch) {
  Result<fs::path> path = file_of(name);
  if (!path.ok()) return path.error();
  const Stamp stamp = this->stamp(name);
  {
    std::lock_guard lock(mutex_);
    for (auto it = prepared_.begin(); it != prepared_.end(); ++it) {
      if (it->name != name || it->stamp != stamp) continue;
      prepared_.splice(prepared_.begin(), prepared_, it);
      return prepared_.front().scene;
    }
  }
  Result<std::shared_ptr<const PreparedScene>> made =
      load_and_prepare_scene(path.value(), build_threads_, {limits_, false, watch, {}});
  if (!made.ok() && made.error().code == ErrorCode::kCanceled) return made;
  std::lock_guard lock(mutex_);
  Known known{stamp, {}, {}};
  if (made.ok()) known.take(made.value()->scene);
  known_[name] = known;
  if (!made.ok()) return made.error();
  std::erase_if(prepared_, [&](const Prepared& p) { return p.name == name; });
  prepared_.push_front({name, stamp, made.value()});
  drop_oldest();
  return made.value();
}

Result<std::shared_ptr<const PreparedScene>> SceneStore::prepare_at(const std::string& name,
                                                                    double seconds,
                                                                    const LoadWatch& watch) {
  const Result<fs::path> path = file_of(name);
  if (!path.ok()) return path.error();
  return load_and_prepare_scene(path.value(), build_threads_, {limits_, false, watch, seconds});
}

// Jobs that still render a scene keep it alive.
void SceneStore::drop_oldest() {
  size_t bytes = 0;
  for (auto it = prepared_.begin(); it != prepared_.end();) {
    bytes += it->scene->size_bytes();
    it = bytes > max_bytes_ && it != prepared_.begin() ? prepared_.erase(it) : std::next(it);
  }
}

Error SceneStore::without_folder(Error error) const {
  for (const fs::path& from : {folder_, uploads_ ? uploads_->folder() : folder_}) {
    const std::string folder = (from / "").string();
    for (std::string* text : {&error.message, &error.where})
      for (size_t at; (at = text->find(folder)) != std::string::npos;)
        text->erase(at, folder.size());
  }
  return error;
}

}  // namespace qray::server
