// Uploaded files by their SHA-256: <data>/assets/<64 hex digits>, each written once. Scenes hold
// hard links to them; one that no scene has goes an hour after it was last asked for, when the
// server starts, a scene is deleted, or room is wanted. Any thread.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/base/sha256.h"
#include "server/store/disk_quota.h"

namespace qray::server {

bool is_asset_name(std::string_view name);

class AssetStore {
 public:
  static constexpr std::chrono::minutes kKeepUnused{60};

  // What broken uploads left is removed, `left` ago.
  static Result<std::unique_ptr<AssetStore>> open(const std::filesystem::path& data,
                                                  DiskQuota& quota, std::chrono::seconds left = {});

  // Bytes on their way: in a file of their own until commit(), gone with this otherwise. One
  // thread.
  class Upload {
   public:
    Upload(Upload&& other) noexcept;
    Upload& operator=(Upload&&) = delete;
    ~Upload();
    Status add(std::span<const uint8_t> bytes);  // kTooLarge: over what was announced
    // On disk when it returns. kInvalid: the bytes are not those of this name.
    Status commit();

   private:
    friend class AssetStore;
    Upload(AssetStore& store, std::string name, uint64_t size);
    AssetStore* store_;
    std::string name_;
    std::filesystem::path file_;
    int fd_ = -1;
    uint64_t size_, left_;
    std::unique_ptr<Sha256> hash_ = std::make_unique<Sha256>();
  };

  bool has(const std::string& name);  // puts off its removal
  // kTooLarge: the quota has no room for `size` bytes. pre: is_asset_name(name).
  Result<Upload> begin(const std::string& name, uint64_t size);
  // kNotFound. A hard link: the asset stays as long as the link.
  Status link(const std::string& name, const std::filesystem::path& to) const;
  // Those that have no link and were not asked for lately.
  void remove_unused(std::chrono::seconds older_than = kKeepUnused);

 private:
  AssetStore(std::filesystem::path folder, DiskQuota& quota)
      : folder_(std::move(folder)), quota_(quota) {}

  std::filesystem::path folder_;
  DiskQuota& quota_;
  std::mutex mutex_;  // of what is there: two uploads of one name, and removal
};

}  // namespace qray::server
