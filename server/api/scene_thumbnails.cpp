#include "server/api/scene_thumbnails.h"

#include <spdlog/spdlog.h>

#include <functional>

#include "core/base/file.h"
#include "core/base/turn.h"
#include "core/image/exposure.h"
#include "core/job/run_job.h"
#include "core/settings/job_settings.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr int kSamples = 32;        // a pixel, before recovery
constexpr double kMostSeconds = 2;  // of rendering
constexpr int kMostDepth = 8;       // surfaces on a path
constexpr uint64_t kMostBytes = 1u << 20;
constexpr const char* kEnding = ".jpg";

RenderSettings settings_for(const Scene& scene) {
  RenderSettings settings = settings_of(JobRequest(), scene);
  const double scale = double{SceneThumbnails::kSide} / std::max(settings.width, settings.height);
  // Recovery works on blocks of 2 x 2 pixels.
  const auto side = [&](int pixels) {
    return std::max(2, 2 * static_cast<int>(pixels * scale / 2));
  };
  settings.width = side(settings.width);
  settings.height = side(settings.height);
  settings.method = "none";
  settings.samples = kSamples;
  settings.seconds = kMostSeconds;
  settings.max_depth = std::min(settings.max_depth, kMostDepth);
  settings.estimates_noise = true;
  return settings;
}

// "<scene>.<stamp>.jpg": its scene; other files have none.
std::string scene_of(const fs::path& file) {
  const std::string name = file.filename().string();
  return file.extension() == kEnding ? name.substr(0, name.find('.')) : "";
}

void remove_if(const fs::path& folder, const std::function<bool(const std::string& scene)>& old) {
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code failed;  // tried again at the next start
    if (old(scene_of(it->path()))) fs::remove(it->path(), failed);
  }
}

}  // namespace

Result<std::unique_ptr<SceneThumbnails>> SceneThumbnails::open(const fs::path& data,
                                                               SceneStore& scenes) {
  std::unique_ptr<SceneThumbnails> made(new SceneThumbnails(data / "thumbnails", scenes));
  std::error_code ec;
  fs::create_directories(made->folder_, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), made->folder_.string()};
  remove_if(made->folder_, [&](const std::string& scene) { return !scenes.has(scene); });
  return made;
}

// The stamp of the scene's files is in the name, so that one of an older scene is not found.
fs::path SceneThumbnails::file_of(const std::string& scene) const {
  return folder_ / (scene + "." + std::to_string(scenes_.stamp(scene)) + kEnding);
}

Result<Bytes> SceneThumbnails::get(const std::string& scene) {
  if (!scenes_.has(scene)) return Error{ErrorCode::kNotFound, "no such scene", ""};
  if (Result<Bytes> kept = read_file(file_of(scene), kMostBytes); kept.ok()) return kept;
  const Turn turn(turns_);
  if (!turn.mine()) return Error{ErrorCode::kBusy, "pictures of other scenes are being made", ""};
  const fs::path file = file_of(scene);
  if (Result<Bytes> kept = read_file(file, kMostBytes); kept.ok()) return kept;  // meanwhile
  Result<Bytes> made = make(scene);
  if (!made.ok()) return made;
  remove_if(folder_, [&](const std::string& other) { return other == scene; });
  if (Status s = write_file_atomic(file, made.value()); !s.ok())
    spdlog::warn("a scene's small picture is not kept: {}", s.error().text());
  return made;
}

Result<Bytes> SceneThumbnails::make(const std::string& name) {
  Result<std::shared_ptr<const PreparedScene>> scene = scenes_.prepare(name);
  if (!scene.ok()) return scenes_.without_folder(scene.error());
  const PreparedScene& prepared = *scene.value();
  const RenderSettings settings = settings_for(prepared.scene);
  Result<Recovery> recovery = included_recovery("default");
  if (!recovery.ok()) return recovery.error();
  Film film(settings.width, settings.height);
  TaskPool pool(1);
  RenderObserver nobody;
  const SteadyClock clock;
  Result<JobResult> done = run_job(prepared, settings, {}, film, pool, nobody, stop_.get_token(),
                                   clock, &recovery.value());
  if (!done.ok()) return done.error();
  Image picture = done.value().recovered ? std::move(*done.value().recovered) : film.develop();
  expose(picture, auto_exposure(picture));
  return encode_image(ImageFormat::kJpeg, picture);
}

}  // namespace qray::server
