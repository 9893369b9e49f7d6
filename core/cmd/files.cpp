#include "core/cmd/files.h"

#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <thread>

#include "core/base/file.h"
#include "core/base/installed.h"
#include "core/image/image_io.h"
#include "core/image/tonemap.h"
#include "core/import/resolve_scene.h"
#include "core/job/run_job.h"
#include "core/recover/included_networks.h"

namespace qray::cmd {
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{4} << 30;

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

bool stores_linear_light(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".exr" || extension == ".hdr" || extension == ".pfm";
}

// A file whose faults name it. `decode`: its bytes to what they hold.
template <typename Decode>
auto read_decoded(const std::filesystem::path& path, uint64_t max_bytes, const Decode& decode)
    -> decltype(decode(Bytes())) {
  Result<Bytes> bytes = read_file(path, max_bytes);
  if (!bytes) return bytes.error();
  auto decoded = decode(bytes.value());
  if (decoded) return decoded;
  Error error = decoded.error();
  error.where = path.string() + (error.where.empty() ? "" : ":" + error.where);
  return error;
}

}  // namespace

Result<std::filesystem::path> find_scene_path(const std::string& scene) {
  return resolve_scene_path(scene, installed_or("scenes", QRAY_SCENES_DIR));
}

Result<std::shared_ptr<const PreparedScene>> prepare_named_scene(const std::string& scene,
                                                                 int threads, ProgressLine& line,
                                                                 std::stop_token stop, bool strict,
                                                                 std::optional<double> seconds) {
  Result<std::filesystem::path> path = find_scene_path(scene);
  if (!path) return path.error();
  const SteadyClock clock;
  const double start = clock.seconds();
  std::mutex mutex;  // the tree is built by several threads
  const LoadWatch watch = [&](LoadStep step, double fraction) {
    std::lock_guard lock(mutex);
    line.show(step == LoadStep::kReading ? "reading" : "building", fraction, "",
              clock.seconds() - start);
    return !stop.stop_requested();
  };
  auto prepared = load_and_prepare_scene(path.value(), threads, {{}, strict, watch, seconds});
  line.finish();
  return prepared;
}

Result<Image> read_linear_image(const std::filesystem::path& path) {
  Result<Image> read = read_image(path);
  if (!read) return read;
  const Image& stored = read.value();
  const bool linear = stores_linear_light(path);
  Image image(stored.width(), stored.height(), 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.set_rgb(x, y, linear ? stored.rgb(x, y) : srgb_to_linear(stored.rgb(x, y)));
  return image;
}

Result<TableFile> read_table(const std::filesystem::path& path) {
  return read_decoded(path, kMaxTableBytes, decode_table);
}

Result<std::optional<TableFile>> read_fitting_table(const std::string& path,
                                                    const SceneHash& hash) {
  if (path.empty()) return std::optional<TableFile>();
  Result<TableFile> table = read_table(path);
  if (!table) return table.error();
  if (!table_fits(table.value().header, hash))
    return Error{ErrorCode::kConflict,
                 "learned from another scene: geometry, materials and lights must be the same",
                 path};
  return std::optional(std::move(table).value());
}

Result<WeightsFile> read_weights(const std::filesystem::path& path) {
  return read_decoded(path, kMaxWeightsBytes, decode_weights);
}

Result<std::optional<Recovery>> find_recovery(const std::string& name) {
  if (name == "none") return std::optional<Recovery>();
  const std::string which = name == "auto" ? "default" : name;
  if (Result<Recovery> included = included_recovery(which); included)
    return std::optional(std::move(included).value());
  else if (included.error().code == ErrorCode::kUnsupported)
    return included.error();
  Result<WeightsFile> file = read_weights(name);
  if (!file) return file.error();
  return std::optional(Recovery{file.value().id, std::move(file.value().network)});
}

Status write_text(const std::filesystem::path& path, std::string_view text) {
  return write_file_atomic(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Status check_writable(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return Error{ErrorCode::kIo, "expected the name of a file, got a folder", path.string()};
  const std::filesystem::path folder = folder_of(path);
  if (!std::filesystem::is_directory(folder, ignored))
    return Error{ErrorCode::kIo, "no such folder", folder.string()};
  if (access(folder.c_str(), W_OK) != 0)
    return Error{ErrorCode::kIo, "no permission to write here", folder.string()};
  return {};
}

Status check_picture_name(const std::filesystem::path& path) {
  if (path.extension() != ".exr" && path.extension() != ".png")
    return Error{ErrorCode::kInvalid, "expected a name ending in .exr or .png", path.string()};
  return check_writable(path);
}

int default_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace qray::cmd
