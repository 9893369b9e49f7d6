#include "server/store/leftovers.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>

#include "core/base/file.h"
#include "server/store/folder_watch.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

// What a folder of the data folder holds; none: it is not there.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    entries.push_back(it->path());
  return entries;
}

class Tidying {
 public:
  Tidying(fs::path data, std::chrono::seconds left) : data_(std::move(data)), left_(left) {}
  ~Tidying() {
    if (removed_ > 0) spdlog::info("removed {} files that a killed server left", removed_);
    if (set_aside_ > 0)
      spdlog::warn("moved {} files to {}: the database does not know whose they are", set_aside_,
                   (data_ / "quarantine").string());
  }

  void remove(const fs::path& path) {
    if (!is_older(path, left_)) return;
    std::error_code ec;
    const auto gone = fs::remove_all(path, ec);
    if (ec) {
      spdlog::warn("{}: {}", path.string(), ec.message());
    } else {
      removed_ += gone;
    }
  }
  void set_aside(const fs::path& path) {
    if (!is_older(path, left_)) return;
    const std::string name =
        path.parent_path().filename().string() + "-" + path.filename().string();
    std::error_code ec;
    fs::create_directories(data_ / "quarantine", ec);
    fs::remove_all(data_ / "quarantine" / name, ec);
    fs::rename(path, data_ / "quarantine" / name, ec);
    if (ec) {
      spdlog::warn("{}: {}", path.string(), ec.message());
    } else {
      ++set_aside_;
    }
  }
  void remove_half_written(const fs::path& folder) {
    for (const fs::path& path : entries_of(folder))
      if (is_half_written(path)) remove(path);
  }

 private:
  const fs::path data_;
  const std::chrono::seconds left_;
  uintmax_t removed_ = 0, set_aside_ = 0;
};

}  // namespace

Status tidy_data_folder(const fs::path& data, JobStore& jobs, TableStore& tables,
                        std::chrono::seconds left) {
  const Result<JobStore::Ids> ids = jobs.ids();
  if (!ids.ok()) return ids.error();
  const Result<std::vector<std::string>> table_ids = tables.ids();
  if (!table_ids.ok()) return table_ids.error();
  const Result<std::vector<JobId>> open = jobs.open();
  if (!open.ok()) return open.error();

  // Step 1: whose files are there, and whether the database should know them all.
  std::vector<std::pair<JobId, fs::path>> of_jobs;
  JobId newest = ids.value().newest;
  for (const char* folder : {"results", "moments", "checkpoints"})
    for (const fs::path& path : entries_of(data / folder))
      if (const std::optional<JobId> id = JobId::parse(path.filename().string())) {
        of_jobs.emplace_back(*id, path);
        newest = std::max(newest, *id);
      }
  const bool forgot = newest > ids.value().newest;
  const std::vector<fs::path> table_files = entries_of(data / "tables");
  if (forgot)
    if (Status s = jobs.give_no_id_up_to(newest); !s.ok()) return s;

  // Step 2: jobs'.
  Tidying tidying(data, left);
  const std::vector<JobId>& known = ids.value().there;
  for (const auto& [id, path] : of_jobs) {
    if (std::binary_search(known.begin(), known.end(), id)) continue;
    if (id > ids.value().newest) {
      tidying.set_aside(path);
    } else {
      tidying.remove(path);
    }
  }
  for (const JobId id : open.value()) {
    const fs::path results = data / "results" / id.text();
    tidying.remove_half_written(results);
    for (const fs::path& frame : entries_of(results))
      if (fs::is_directory(frame)) tidying.remove_half_written(frame);
  }
  for (const char* folder : {"checkpoints", "tables", "weights", "thumbnails"})
    tidying.remove_half_written(data / folder);
  for (const fs::path& scene : entries_of(data / "scenes")) tidying.remove_half_written(scene);

  // Step 3: tables.
  const std::set<std::string> recorded(table_ids.value().begin(), table_ids.value().end());
  std::set<std::string> there;
  for (const fs::path& path : table_files) {
    if (path.extension() != ".qrt") continue;
    if (recorded.contains(path.stem().string())) {
      there.insert(path.stem().string());
    } else if (forgot || jobs.is_new()) {
      tidying.set_aside(path);
    } else {
      tidying.remove(path);
    }
  }
  for (const std::string& id : recorded) {
    if (there.contains(id) || left > std::chrono::seconds(0)) continue;
    spdlog::warn("table {} is not listed any more: its file is gone", id);
    if (Status s = tables.quarantine(id); !s.ok()) return s;
  }
  return {};
}

}  // namespace qray::server
