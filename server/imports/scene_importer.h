// From POST /v1/scenes to a scene that jobs may name: its files linked, read in a process of their
// own, kept. Few at a time. Any thread; stop() once.
#pragma once

#include <semaphore>
#include <stop_token>
#include <variant>

#include "server/imports/import_child.h"
#include "server/store/uploaded_scenes.h"

namespace qray::server {

class SceneImporter {
 public:
  SceneImporter(AssetStore& assets, UploadedScenes& scenes, DiskQuota& quota, ImportLimits limits,
                int at_once)
      : assets_(assets),
        scenes_(scenes),
        quota_(quota),
        limits_(std::move(limits)),
        turns_(at_once) {}

  struct Imported {
    std::string name;
    bool is_new;
  };
  std::variant<Imported, proto::Problem> import(proto::SceneRequest request);
  // Ends what is being read.
  void stop() { stop_.request_stop(); }

 private:
  std::optional<proto::Problem> missing_assets(const proto::SceneRequest& request);
  std::variant<Imported, proto::Problem> read(const proto::SceneRequest& request,
                                              const std::string& name);

  AssetStore& assets_;
  UploadedScenes& scenes_;
  DiskQuota& quota_;
  ImportLimits limits_;
  std::counting_semaphore<> turns_;
  std::stop_source stop_;
};

}  // namespace qray::server
