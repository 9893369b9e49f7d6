// Small pictures of scenes, for lists: made when somebody first asks, kept in <data>/thumbnails,
// and made anew once the scene has changed. One is made at a time, by one thread. Any thread;
// stop() once.
#pragma once

#include <filesystem>
#include <semaphore>
#include <stop_token>

#include "server/store/scene_store.h"

namespace qray::server {

class SceneThumbnails {
 public:
  static constexpr int kSide = 192;  // pixels, the longer one

  // Those of scenes that are gone are removed.
  static Result<std::unique_ptr<SceneThumbnails>> open(const std::filesystem::path& data,
                                                       SceneStore& scenes);
  // A JPEG. kNotFound: no such scene; kBusy: others are being made; else what is wrong in the
  // scene.
  Result<Bytes> get(const std::string& scene);
  // Ends what is being made.
  void stop() { stop_.request_stop(); }

 private:
  SceneThumbnails(std::filesystem::path folder, SceneStore& scenes)
      : folder_(std::move(folder)), scenes_(scenes) {}
  std::filesystem::path file_of(const std::string& scene) const;
  Result<Bytes> make(const std::string& scene);

  std::filesystem::path folder_;
  SceneStore& scenes_;
  std::counting_semaphore<> turns_{1};
  std::stop_source stop_;
};

}  // namespace qray::server
