#include "core/cmd/upload.h"

#include <cstdio>
#include <fstream>
#include <vector>

#include "core/base/clock.h"
#include "core/base/sha256.h"
#include "core/cmd/progress_line.h"

namespace qray::cmd {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMaxFiles = 4096;
constexpr uint64_t kMaxBytes = uint64_t{1} << 30;

Error io_error(const fs::path& path, const char* message) {
  return {ErrorCode::kNotFound, message, path.string()};
}

struct LocalFile {
  std::string name;  // from the scene's folder on, with /
  fs::path path;
  uint64_t bytes;
};

Result<std::vector<LocalFile>> files_below(const fs::path& folder) {
  std::vector<LocalFile> files;
  uint64_t sum = 0;
  std::error_code ec;
  for (fs::recursive_directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code failed;
    if (!it->is_regular_file(failed)) continue;
    const uint64_t bytes = it->file_size(failed);
    if (failed) return io_error(it->path(), "cannot be read");
    sum += bytes;
    if (files.size() == kMaxFiles || sum > kMaxBytes)
      return Error{ErrorCode::kTooLarge,
                   "expected a folder of at most " + std::to_string(kMaxFiles) +
                       " files and 1 GiB: move the scene into one of its own",
                   folder.string()};
    files.push_back({it->path().lexically_relative(folder).generic_string(), it->path(), bytes});
  }
  if (ec) return io_error(folder, "cannot be read");
  return files;
}

Result<std::string> hash_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  Sha256 hash;
  std::vector<char> block(size_t{1} << 20);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0)
    hash.add({reinterpret_cast<const uint8_t*>(block.data()), static_cast<size_t>(in.gcount())});
  if (in.bad() || !in.eof()) return io_error(path, "cannot be read");
  return hash.finish().hex();
}

class Uploader {
 public:
  explicit Uploader(ServiceClient& client) : client_(client) {}

  // The asset's SHA-256.
  Result<std::string> send(const LocalFile& file) {
    Result<std::string> hash = hash_of(file.path);
    if (!hash) return hash;
    if (Status s = client_.put_asset(hash.value(), file.path, file.bytes); !s) return s.error();
    sent_ += file.bytes;
    return hash;
  }
  void show(uint64_t total) {
    const double seconds = clock_.seconds() - start_;
    const double fraction =
        total > 0 ? static_cast<double>(sent_) / static_cast<double>(total) : 1.0;
    if (seconds > 1)
      line_.show("uploading", fraction, std::to_string(sent_ >> 20) + " MiB", seconds);
  }
  void finish() { line_.finish(); }

 private:
  ServiceClient& client_;
  ProgressLine line_;
  SteadyClock clock_;
  double start_ = clock_.seconds();
  uint64_t sent_ = 0;
};

Result<proto::SceneSubmission> send_files(ServiceClient& client, const fs::path& path,
                                          bool is_folder) {
  proto::SceneSubmission scene;
  const fs::path folder = is_folder ? path : fs::absolute(path).parent_path();
  if (!is_folder) scene.entry = path.filename();
  const Result<std::vector<LocalFile>> files = files_below(folder);
  if (!files) return files.error();
  uint64_t total = 0;
  for (const LocalFile& file : files.value()) total += file.bytes;
  Uploader uploader(client);
  for (const LocalFile& file : files.value()) {
    uploader.show(total);
    Result<std::string> hash = uploader.send(file);
    if (!hash) return hash.error();
    scene.files[file.name] = std::move(hash).value();
  }
  uploader.finish();
  return scene;
}

}  // namespace

Result<std::string> upload_scene(ServiceClient& client, const fs::path& path) {
  proto::SceneSubmission scene;
  const std::string extension = path.extension();
  std::error_code ec;
  const bool is_folder = fs::is_directory(path, ec);
  if (!is_folder && (extension == ".glb" || extension == ".zip")) {
    const uint64_t bytes = fs::file_size(path, ec);
    if (ec) return io_error(path, "cannot be read");
    Result<std::string> hash = Uploader(client).send({"", path, bytes});
    if (!hash) return hash;
    scene.asset = std::move(hash).value();
    scene.type = extension.substr(1);
  } else {
    Result<proto::SceneSubmission> sent = send_files(client, path, is_folder);
    if (!sent) return sent.error();
    scene = std::move(sent).value();
  }
  const Result<proto::SceneView> made = client.post_scene(scene);
  if (!made) return made.error();
  for (const std::string& warning : made.value().warnings)
    std::fprintf(stderr, "qray: warning: %s\n", warning.c_str());
  return made.value().name;
}

}  // namespace qray::cmd
