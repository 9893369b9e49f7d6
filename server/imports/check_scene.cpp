#include "server/imports/check_scene.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <cstdlib>
#include <new>

#include "core/image/picture_reader.h"
#include "core/import/scene_entry.h"
#include "core/job/load_and_prepare.h"
#include "proto/messages.h"
#include "server/imports/unzip.h"
#include "server/store/disk_quota.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMaxWarnings = 100, kMaxTextBytes = 500;
constexpr rlim_t kMaxFiles = 256;

bool limit(int resource, rlim_t value) {
  const rlimit both{value, value};
  return ::setrlimit(static_cast<__rlimit_resource_t>(resource), &both) == 0;
}

// Before anything of the upload is looked at. False: no limits, so no reading either.
bool confine(const CheckScene& check) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != check.parent) return false;  // it ended before the line above
  std::signal(SIGXFSZ, SIG_IGN);                  // a write over the limit is an error
  std::set_new_handler([] { ::_exit(CheckScene::kOutOfMemory); });
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve terabytes
  // Libraries start a thread a processor; each reserves 64 MiB for its memory and 8 for its stack.
  ::mallopt(M_ARENA_MAX, 2);
  pthread_attr_t small;
  pthread_attr_init(&small);
  pthread_attr_setstacksize(&small, size_t{1} << 20);
  pthread_setattr_default_np(&small);
  pthread_attr_destroy(&small);
  if (!limit(RLIMIT_AS, check.memory_mib << 20)) return false;
#endif
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && limit(RLIMIT_CPU, check.seconds + 1) &&
         limit(RLIMIT_FSIZE, check.unpacked_bytes) && limit(RLIMIT_NOFILE, kMaxFiles) &&
         limit(RLIMIT_CORE, 0);
}

// Every picture to its last row: the server reads textures when a ray first meets them, too late
// to refuse one.
Status decode_textures(const Scene& scene) {
  for (const Texture& texture : scene.textures)
    if (Status s = read_picture_rows(texture.path, texture.bytes.get(), INT_MAX, [](auto) {});
        !s.ok())
      return s;
  return {};
}

Result<proto::SceneReport> examine(const CheckScene& check) {
  proto::SceneReport report;
  report.entry = check.entry;
  const fs::path files = check.folder / "files", archive = check.folder / "upload.zip";
  if (std::error_code ec; fs::exists(archive, ec)) {
    const Result<Unzipped> unzipped = unzip(archive, files, check.unpacked_bytes);
    if (!unzipped.ok()) return unzipped.error();
    // Each file's last block is hardly ever full.
    report.unpacked_bytes =
        unzipped.value().bytes + unzipped.value().names.size() * DiskQuota::on_disk(0);
    if (report.entry.empty()) {
      Result<std::string> found = find_scene_entry(unzipped.value().names);
      if (!found.ok()) return found.error();
      report.entry = std::move(found).value();
    }
  }
  std::error_code ec;
  if (!fs::is_regular_file(files / report.entry, ec))
    return Error{ErrorCode::kNotFound, "there is no such file", report.entry};
  LoadOptions options;
  options.limits.max_triangles = check.max_triangles;
  const auto prepared = load_and_prepare_scene(files / report.entry, /*build_threads=*/1, options);
  if (!prepared.ok()) {
    const Error& error = prepared.error();
    if (error.code == ErrorCode::kTooLarge && error.where == "Embree")
      ::_exit(CheckScene::kOutOfMemory);
    return error;
  }
  const PreparedScene& scene = *prepared.value();
  if (Status s = decode_textures(scene.scene); !s.ok()) return s.error();
  report.width = scene.scene.width;
  for (const NamedCamera& own : scene.scene.cameras) report.cameras.push_back(own.name);
  report.height = scene.scene.height;
  report.triangles = scene.scene.triangle_count();
  report.warnings = scene.warnings;
  return report;
}

// For clients: no path of this machine, and no more than a page of text.
void tidy(std::string& text, const fs::path& files) {
  std::error_code ec;
  for (const fs::path& folder : {files, fs::canonical(files, ec)}) {
    const std::string prefix = (folder / "").string();
    if (prefix == "/") continue;
    for (size_t at; (at = text.find(prefix)) != std::string::npos;) text.erase(at, prefix.size());
  }
  if (text.size() > kMaxTextBytes) text = text.substr(0, kMaxTextBytes) + "...";
}

}  // namespace

std::vector<std::string> CheckScene::arguments() const {
  return {"qrayd",
          kCommand,
          folder.string(),
          entry,
          std::to_string(memory_mib),
          std::to_string(seconds),
          std::to_string(unpacked_bytes),
          std::to_string(max_triangles),
          std::to_string(parent)};
}

std::optional<CheckScene> CheckScene::parse(int argc, const char* const* argv) {
  if (argc != 9 || std::string_view(argv[1]) != kCommand) return std::nullopt;
  const auto number = [&](int i) { return std::strtoull(argv[i], nullptr, 10); };
  return CheckScene{
      argv[2], argv[3], number(4), number(5), number(6), number(7), static_cast<int>(number(8))};
}

int check_scene(const CheckScene& check) {
  if (!confine(check)) return 1;
  Result<proto::SceneReport> examined = examine(check);
  proto::SceneReport report;
  if (examined.ok()) {
    report = std::move(examined).value();
  } else {
    report.error = proto::JobError{examined.error().message, examined.error().where};
    tidy(report.error->message, check.folder / "files");
    tidy(report.error->where, check.folder / "files");
  }
  if (report.warnings.size() > kMaxWarnings) {
    report.warnings.resize(kMaxWarnings);
    report.warnings.push_back("there are more warnings than these");
  }
  for (std::string& warning : report.warnings) tidy(warning, check.folder / "files");
  const std::string line = proto::scene_report_to_json(report) + "\n";
  for (size_t done = 0; done < line.size();) {
    const ssize_t n = ::write(CheckScene::kReportFd, line.data() + done, line.size() - done);
    if (n <= 0) return 1;
    done += static_cast<size_t>(n);
  }
  ::_exit(0);  // libraries that end slowly, or badly, change nothing any more
}

}  // namespace qray::server
