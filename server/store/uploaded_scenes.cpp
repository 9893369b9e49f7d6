#include "server/store/uploaded_scenes.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <random>
#include <set>

#include "core/base/file.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr const char* kDraft = ".draft";
constexpr uint64_t kMaxReportBytes = 4u << 20;

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

Error io_error(const std::error_code& ec, const fs::path& path) {
  return {ErrorCode::kIo, ec.message(), path.string()};
}

// Everything that a folder holds, wherever it is: one call instead of one a file.
Status sync_all(const fs::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = fd >= 0 && ::syncfs(fd) == 0;
  const Error error{ErrorCode::kIo, std::string("cannot write: ") + std::strerror(errno),
                    folder.string()};
  if (fd >= 0) ::close(fd);
  return synced ? Status() : error;
}

}  // namespace

bool UploadedScenes::is_name(std::string_view name) {
  return name.size() == 35 && name.starts_with("up-") &&
         name.find_first_not_of("0123456789abcdef", 3) == std::string_view::npos;
}

std::string UploadedScenes::name_of(const proto::SceneRequest& request) {
  return "up-" + sha256(bytes_of(proto::scene_manifest(request))).hex().substr(0, 32);
}

Result<std::unique_ptr<UploadedScenes>> UploadedScenes::open(const fs::path& data, DiskQuota& quota,
                                                             std::chrono::seconds left) {
  std::unique_ptr<UploadedScenes> scenes(new UploadedScenes(data / "scenes", quota));
  std::error_code ec;
  fs::create_directories(scenes->folder_, ec);
  if (ec) return io_error(ec, scenes->folder_);
  for (fs::directory_iterator it(scenes->folder_, ec), end; !ec && it != end; it.increment(ec)) {
    if (it->path().extension() != kDraft || !is_older(it->path(), left)) continue;
    std::error_code failed;
    fs::remove_all(it->path(), failed);
    if (failed) return io_error(failed, it->path());
  }
  if (ec) return io_error(ec, scenes->folder_);
  scenes->watch_.changed(scenes->folder_);
  if (Status s = scenes->look_again(); !s.ok()) return s.error();
  return scenes;
}

bool UploadedScenes::read(const std::string& name) const {
  const Result<Bytes> text = read_file(folder_ / name / "report.json", kMaxReportBytes);
  std::optional<proto::SceneReport> report;
  if (text.ok())
    report = proto::parse_scene_report(
        {reinterpret_cast<const char*>(text.value().data()), text.value().size()});
  if (!report) return false;
  if (!scenes_.contains(name)) quota_.note(report->unpacked_bytes);
  scenes_.insert_or_assign(name, std::move(*report));
  return true;
}

Status UploadedScenes::look_again() const {
  std::set<std::string, std::less<>> there;
  std::error_code ec;
  for (fs::directory_iterator it(folder_, ec), end; !ec && it != end; it.increment(ec)) {
    const std::string name = it->path().filename();
    if (!is_name(name)) continue;
    there.insert(name);
    if (!read(name))
      spdlog::warn("scene {}: its report.json cannot be read: upload it again", name);
  }
  if (ec) return io_error(ec, folder_);
  std::erase_if(scenes_, [&](const auto& scene) {
    const bool gone = !there.contains(scene.first);
    if (gone) quota_.give_back(scene.second.unpacked_bytes);
    return gone;
  });
  return {};
}

void UploadedScenes::look_again_if_changed() const {
  if (!watch_.changed(folder_)) return;
  if (Status s = look_again(); !s.ok()) spdlog::warn("scenes: {}", s.error().text());
}

fs::path UploadedScenes::draft_folder() const {
  std::random_device random;
  std::string name;
  for (int i = 0; i < 4; ++i) name += std::to_string(random()) + (i < 3 ? "-" : kDraft);
  return folder_ / name;
}

UploadedScenes::Draft::~Draft() {
  std::error_code ec;
  if (!folder_.empty()) fs::remove_all(folder_, ec);
  if (ec) spdlog::warn("{}: {}", folder_.string(), ec.message());
}

Result<UploadedScenes::Draft> UploadedScenes::begin(const proto::SceneRequest& request,
                                                    const AssetStore& assets) {
  Draft draft(draft_folder());
  const fs::path files = draft.folder() / "files";
  std::error_code ec;
  fs::create_directories(files, ec);
  if (ec) return io_error(ec, files);
  if (!request.archive.empty())
    if (Status s = assets.link(request.archive, draft.folder() / "upload.zip"); !s.ok())
      return s.error();
  for (const auto& [name, hash] : request.files) {
    fs::create_directories((files / name).parent_path(), ec);
    if (ec) return io_error(ec, files / name);
    if (Status s = assets.link(hash, files / name); !s.ok()) return s.error();
  }
  const std::string manifest = proto::scene_manifest(request);
  if (Status s = write_file_atomic(draft.folder() / "manifest.json", bytes_of(manifest)); !s.ok())
    return s.error();
  return draft;
}

Status UploadedScenes::keep(Draft draft, const std::string& name,
                            const proto::SceneReport& report) {
  const std::string text = proto::scene_report_to_json(report);
  if (Status s = write_file_atomic(draft.folder() / "report.json", bytes_of(text)); !s.ok())
    return s;
  if (Status s = sync_all(draft.folder()); !s.ok()) return s;
  std::error_code ec;
  std::lock_guard lock(mutex_);
  if (!scenes_.contains(name)) fs::remove_all(folder_ / name, ec);  // one whose report was lost
  fs::rename(draft.folder(), folder_ / name, ec);
  if (ec) return io_error(ec, folder_ / name);
  draft.folder_.clear();
  sync_folder(folder_);
  scenes_.insert_or_assign(name, report);
  return {};
}

std::optional<proto::SceneReport> UploadedScenes::find(std::string_view name) const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  auto found = scenes_.find(name);
  // A folder that is shared over a network may show an entry before it shows that it has changed.
  if (found == scenes_.end() && is_name(name) && read(std::string(name)))
    found = scenes_.find(name);
  return found == scenes_.end() ? std::nullopt : std::optional(found->second);
}

size_t UploadedScenes::count() const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  return scenes_.size();
}

std::optional<fs::path> UploadedScenes::file(std::string_view name) const {
  const std::optional<proto::SceneReport> report = find(name);
  if (!report) return std::nullopt;
  return folder_ / name / "files" / report->entry;
}

std::vector<proto::SceneInfo> UploadedScenes::list() const {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  std::vector<proto::SceneInfo> infos;
  for (const auto& [name, report] : scenes_)
    infos.push_back({name, report.width, report.height, true, report.title});
  return infos;
}

Status UploadedScenes::rename(const std::string& name, const std::string& title) {
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return Error{ErrorCode::kNotFound, "no uploaded scene " + name, ""};
  proto::SceneReport report = found->second;
  report.title = title;
  const std::string text = proto::scene_report_to_json(report);
  if (Status s = write_file_atomic(folder_ / name / "report.json", bytes_of(text)); !s.ok())
    return s;
  found->second = std::move(report);
  ::utimensat(AT_FDCWD, folder_.c_str(), nullptr, 0);  // so that other servers look
  return {};
}

Status UploadedScenes::remove(const std::string& name) {
  const Draft trash(draft_folder());  // a crash on the way leaves nothing that looks like a scene
  std::lock_guard lock(mutex_);
  look_again_if_changed();
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return Error{ErrorCode::kNotFound, "no uploaded scene " + name, ""};
  std::error_code ec;
  fs::rename(folder_ / name, trash.folder(), ec);
  if (ec) return io_error(ec, folder_ / name);
  sync_folder(folder_);
  quota_.give_back(found->second.unpacked_bytes);
  scenes_.erase(found);
  return {};
}

}  // namespace qray::server
