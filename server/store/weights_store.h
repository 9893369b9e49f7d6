// Networks for recovery: files <data>/weights/<id>.qrw, all known in memory (they are few and
// small). One that cannot be read goes to <data>/quarantine. Any thread.
#pragma once

#include <filesystem>
#include <mutex>

#include "core/recover/weights_file.h"
#include "core/scene/scene.h"
#include "proto/messages.h"
#include "server/store/folder_watch.h"

namespace qray::server {

class WeightsStore {
 public:
  static constexpr size_t kMost = 1000;  // files

  static Result<std::unique_ptr<WeightsStore>> open(std::filesystem::path data);

  // kInvalid: there are kMost. The same again is no error.
  Status add(const WeightsFile& weights);
  std::vector<proto::WeightsInfo> list() const;                  // newest first
  Result<proto::WeightsInfo> find(const std::string& id) const;  // kNotFound
  // Reads the file anew. kNotFound; kCorrupt, kUnsupported: it has gone to quarantine.
  Result<WeightsFile> load(const std::string& id);
  // The newest that learned from this very scene.
  std::optional<std::string> fitting(const SceneHash& scene) const;
  Status remove(const std::string& id);  // kNotFound

 private:
  struct Entry {
    proto::WeightsInfo info;
    SceneHash scene;
  };
  explicit WeightsStore(std::filesystem::path data) : data_(std::move(data)) {}
  std::filesystem::path file_of(const std::string& id) const;
  Result<WeightsFile> read(const std::string& id) const;
  void note(const WeightsFile& weights, int64_t created_ms) const;
  // What other servers have added or removed. Under the mutex.
  void look_again_if_changed() const;
  Status look_again() const;

  std::filesystem::path data_;
  mutable std::mutex mutex_;
  mutable std::vector<Entry> entries_;  // oldest first
  mutable FolderWatch watch_;
};

}  // namespace qray::server
