// The scenes folder: names, and prepared scenes kept for the next job, as many as memory allows. A
// scene is loaded anew when a file in its folder has changed; uploaded ones never do. Any
// thread.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>

#include "core/job/load_and_prepare.h"
#include "proto/messages.h"
#include "server/store/uploaded_scenes.h"

namespace qray::server {

class SceneStore {
 public:
  // `max_bytes`: of the prepared scenes; the newest is kept whatever its size.
  SceneStore(std::filesystem::path folder, int build_threads, size_t max_bytes,
             const SceneLimits& limits = {})
      : folder_(std::move(folder)),
        build_threads_(build_threads),
        max_bytes_(max_bytes),
        limits_(limits) {}

  // Uploaded scenes too, from now on. Before any other call.
  void add_uploads(const UploadedScenes& uploads) { uploads_ = &uploads; }

  bool has(std::string_view name) const;
  // Sorted by name. A scene's size is known once it was loaded without error since it last changed.
  std::vector<proto::SceneInfo> list();
  // The picture size of one scene; none when it cannot be loaded.
  std::optional<std::pair<int, int>> size(const std::string& name);
  // The cameras that it names; none when it cannot be loaded.
  std::vector<std::string> cameras(const std::string& name);
  // kNotFound, kCanceled by the watch, or what is wrong in the scene, with file and place.
  Result<std::shared_ptr<const PreparedScene>> prepare(const std::string& name,
                                                       const LoadWatch& watch = {});
  // The scene as its file moves it (Scene::moves_surfaces), which is not kept.
  Result<std::shared_ptr<const PreparedScene>> prepare_at(const std::string& name, double seconds,
                                                          const LoadWatch& watch = {});
  // Of a scene's files: another one once they have changed.
  uint64_t stamp(const std::string& name) const;
  // The error as a client may see it: files are named from the scenes folder on.
  Error without_folder(Error error) const;

 private:
  using Stamp = uint64_t;  // of a folder's files: names, sizes, times
  struct Prepared {
    std::string name;
    Stamp stamp;
    std::shared_ptr<const PreparedScene> scene;
  };
  struct Known {
    Stamp stamp;
    std::optional<std::pair<int, int>> size;
    std::vector<std::string> cameras;
    void take(const Scene& scene);
  };
  Result<std::filesystem::path> file_of(std::string_view name) const;
  void drop_oldest();

  std::filesystem::path folder_;
  const UploadedScenes* uploads_ = nullptr;
  int build_threads_;
  size_t max_bytes_;
  SceneLimits limits_;
  std::mutex mutex_;
  std::list<Prepared> prepared_;  // newest use first
  std::map<std::string, Known> known_;
};

}  // namespace qray::server
