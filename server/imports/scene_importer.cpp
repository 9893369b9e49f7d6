#include "server/imports/scene_importer.h"

#include <spdlog/spdlog.h>

#include "core/base/file_names.h"
#include "core/base/turn.h"
#include "core/import/scene_entry.h"

namespace qray::server {
namespace {

constexpr size_t kMaxNamed = 32;  // of missing files

proto::Problem wrong(std::string pointer, std::string detail) {
  std::string text = pointer.empty() ? detail : pointer + ": " + detail;
  return {422, "Wrong scene", std::move(text), {{std::move(pointer), std::move(detail)}}};
}

proto::Problem not_stored(const Error& error) {
  spdlog::error("an uploaded scene is not stored: {}", error.text());
  return {503, "Not stored", "the server could not keep or read it; its log has more", {}};
}

// Where in the request the fault lies: the file that the error's place begins with, if it is one.
proto::Problem refused(const proto::SceneRequest& request, const proto::JobError& error) {
  const std::string detail =
      error.where.empty() ? error.message : error.where + ": " + error.message;
  if (!request.archive.empty()) return wrong("/asset", detail);
  const std::string file = error.where.substr(0, error.where.find(':'));
  return wrong(proto::file_pointer(request.files.contains(file) ? file : request.entry), detail);
}

}  // namespace

std::optional<proto::Problem> SceneImporter::missing_assets(const proto::SceneRequest& request) {
  std::vector<proto::FieldError> missing;
  const auto look = [&](const std::string& pointer, const std::string& hash) {
    if (missing.size() < kMaxNamed && !assets_.has(hash))
      missing.push_back({pointer, "no such asset: PUT /v1/assets/" + hash + " first"});
  };
  if (!request.archive.empty()) look("/asset", request.archive);
  for (const auto& [name, hash] : request.files) look(proto::file_pointer(name), hash);
  if (missing.empty()) return std::nullopt;
  std::string detail = missing.front().pointer + ": " + missing.front().detail;
  return proto::Problem{422, "Missing assets", std::move(detail), std::move(missing)};
}

std::variant<SceneImporter::Imported, proto::Problem> SceneImporter::import(
    proto::SceneRequest request) {
  if (request.entry.empty() && request.archive.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, hash] : request.files) names.push_back(name);
    Result<std::string> entry = find_scene_entry(names);
    if (!entry.ok()) return wrong("/files", entry.error().message);
    request.entry = std::move(entry).value();
  }
  const std::string name = UploadedScenes::name_of(request);
  if (scenes_.find(name)) return Imported{name, false};
  const Turn turn(turns_);
  if (!turn.mine()) return proto::Problem{503, "Busy", "other scenes are being read", {}};
  if (scenes_.find(name)) return Imported{name, false};  // meanwhile
  return read(request, name);
}

std::variant<SceneImporter::Imported, proto::Problem> SceneImporter::read(
    const proto::SceneRequest& request, const std::string& name) {
  if (auto problem = missing_assets(request)) return *problem;
  if (scenes_.count() >= UploadedScenes::kMost)
    return proto::Problem{507,
                          "Insufficient storage",
                          "there are " + std::to_string(UploadedScenes::kMost) +
                              " uploaded scenes: delete some that are not needed",
                          {}};
  // Room for all that it may unpack, until it is known how much that is.
  const uint64_t room = request.archive.empty()
                            ? 0
                            : limits_.unpacked_bytes + FileNames::kMost * DiskQuota::on_disk(0);
  if (!quota_.take(room)) {
    assets_.remove_unused();
    if (!quota_.take(room))
      return proto::Problem{507,
                            "Insufficient storage",
                            "no room to unpack it: delete scenes that are not needed",
                            {}};
  }
  struct GiveBack {
    DiskQuota& quota;
    uint64_t bytes;
    ~GiveBack() { quota.give_back(bytes); }
  } unused{quota_, room};

  Result<UploadedScenes::Draft> draft = scenes_.begin(request, assets_);
  if (!draft.ok()) return not_stored(draft.error());
  Result<proto::SceneReport> report =
      read_upload(limits_, draft.value().folder(), request.entry, stop_.get_token());
  if (!report.ok() && report.error().code == ErrorCode::kCanceled)
    return proto::Problem{503, "Stopping", "the server stops", {}};
  if (!report.ok()) return not_stored(report.error());
  if (report.value().error) return refused(request, *report.value().error);
  if (report.value().unpacked_bytes > room)
    return not_stored({ErrorCode::kTooLarge, "unpacked more than it may", name});
  report.value().title = request.title;
  if (Status s = scenes_.keep(std::move(draft).value(), name, report.value()); !s.ok())
    return not_stored(s.error());
  unused.bytes -= report.value().unpacked_bytes;
  return Imported{name, true};
}

}  // namespace qray::server
