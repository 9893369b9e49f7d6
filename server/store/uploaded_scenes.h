// Scenes that came over HTTP: <data>/scenes/<name>/ has files/ (links to assets, or what an archive
// held), manifest.json and report.json. A name says the content: "up-" and 32 hex digits of the
// manifest's SHA-256. Any thread.
#pragma once

#include <map>

#include "proto/messages.h"
#include "server/store/asset_store.h"
#include "server/store/folder_watch.h"

namespace qray::server {

class UploadedScenes {
 public:
  static constexpr size_t kMost = 1000;

  // What was being made when a server ended is removed, `left` ago.
  static Result<std::unique_ptr<UploadedScenes>> open(const std::filesystem::path& data,
                                                      DiskQuota& quota,
                                                      std::chrono::seconds left = {});
  // Of a scene that is, or may be, uploaded.
  static bool is_name(std::string_view name);
  static std::string name_of(const proto::SceneRequest& request);

  // A scene to be: a folder with its files, gone with this unless it is kept. One thread.
  class Draft {
   public:
    explicit Draft(std::filesystem::path folder) : folder_(std::move(folder)) {}
    Draft(Draft&& other) noexcept : folder_(std::exchange(other.folder_, {})) {}
    Draft& operator=(Draft&&) = delete;
    ~Draft();
    const std::filesystem::path& folder() const { return folder_; }

   private:
    friend class UploadedScenes;
    std::filesystem::path folder_;
  };
  // kNotFound: an asset went meanwhile.
  Result<Draft> begin(const proto::SceneRequest& request, const AssetStore& assets);
  // On disk when it returns; what it unpacked is from then on counted here.
  Status keep(Draft draft, const std::string& name, const proto::SceneReport& report);

  std::optional<proto::SceneReport> find(std::string_view name) const;
  std::optional<std::filesystem::path> file(std::string_view name) const;  // of the scene
  std::vector<proto::SceneInfo> list() const;                              // sorted by name
  size_t count() const;
  Status remove(const std::string& name);                            // kNotFound
  Status rename(const std::string& name, const std::string& title);  // kNotFound
  const std::filesystem::path& folder() const { return folder_; }

 private:
  UploadedScenes(std::filesystem::path folder, DiskQuota& quota)
      : folder_(std::move(folder)), quota_(quota) {}
  // What other servers have made or removed. Under the mutex.
  Status look_again() const;
  bool read(const std::string& name) const;
  void look_again_if_changed() const;
  // Of a name that nobody guesses: a scene that names its own draft is told what any other path is.
  std::filesystem::path draft_folder() const;

  std::filesystem::path folder_;
  DiskQuota& quota_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, proto::SceneReport, std::less<>> scenes_;
  mutable FolderWatch watch_;
};

}  // namespace qray::server
