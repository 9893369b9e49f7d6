#include "core/image/animation.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <vector>

#include "core/image/image_library.h"
#include "core/image/tonemap.h"

extern char** environ;

namespace qray {
namespace fs = std::filesystem;
namespace {

std::vector<uint8_t> rgb24(const Image& image) {
  std::vector<uint8_t> bytes;
  bytes.reserve(size_t{3} * static_cast<size_t>(image.width()) *
                static_cast<size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const Rgb color = image.rgb(x, y);
      for (const float v : {color.r, color.g, color.b})
        bytes.push_back(static_cast<uint8_t>(linear_to_srgb(v) * 255 + 0.5f));
    }
  return bytes;
}

// The program, fed through a socket, whose end is no signal.
class Ffmpeg {
 public:
  static Result<Ffmpeg> start(std::vector<std::string> arguments) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      return Error{ErrorCode::kIo, std::strerror(errno), "ffmpeg"};
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
    for (int fd : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_RDWR, 0);
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    pid_t pid = 0;
    const int error = ::posix_spawnp(&pid, "ffmpeg", &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    ::close(ends[1]);
    if (error == 0) return Ffmpeg(pid, ends[0]);
    ::close(ends[0]);
    return Error{ErrorCode::kUnsupported,
                 std::string("ffmpeg cannot be started: ") + std::strerror(error), "ffmpeg"};
  }
  Ffmpeg(Ffmpeg&& other) noexcept
      : pid_(std::exchange(other.pid_, 0)), in_(std::exchange(other.in_, -1)) {}
  Ffmpeg& operator=(Ffmpeg&&) = delete;
  ~Ffmpeg() {
    if (in_ >= 0) ::close(in_);
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

  bool feed(const std::vector<uint8_t>& bytes) const {
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t n = ::send(in_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      at += static_cast<size_t>(n);
    }
    return true;
  }
  // No more comes. Whether it did all that it should.
  bool end() {
    ::close(std::exchange(in_, -1));
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
    pid_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  Ffmpeg(pid_t pid, int in) : pid_(pid), in_(in) {}
  pid_t pid_;
  int in_;
};

std::string text_of(double v) {
  std::ostringstream text;
  text << v;
  return text.str();
}

Status write_mp4(const fs::path& path, const Animation& animation) {
  if (!has_ffmpeg())
    return Error{ErrorCode::kUnsupported, "needs the program ffmpeg, which is not on this machine",
                 path.string()};
  std::optional<Ffmpeg> ffmpeg;
  const Error failed{ErrorCode::kIo, "ffmpeg could not write it", path.string()};
  for (int i = 0; i < animation.count; ++i) {
    const Result<Image> image = animation.picture(i);
    if (!image.ok()) return image.error();
    if (!ffmpeg) {
      const std::string size =
          std::to_string(image.value().width()) + "x" + std::to_string(image.value().height());
      Result<Ffmpeg> started =
          Ffmpeg::start({"ffmpeg",
                         "-nostdin",
                         "-v",
                         "error",
                         "-y",
                         "-f",
                         "rawvideo",
                         "-pix_fmt",
                         "rgb24",
                         "-s",
                         size,
                         "-r",
                         text_of(animation.per_second),
                         "-i",
                         "pipe:0",
                         "-an",
                         "-vf",
                         "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
                         "-colorspace",
                         "bt709",
                         "-color_primaries",
                         "bt709",
                         "-color_trc",
                         "iec61966-2-1",
                         "-c:v",
                         "libx264",
                         "-crf",
                         "16",
                         "-pix_fmt",
                         "yuv420p",
                         "-movflags",
                         "+faststart",
                         "-f",
                         "mp4",
                         fs::absolute(path).string()});
      if (!started.ok()) return started.error();
      ffmpeg.emplace(std::move(started).value());
    }
    if (!ffmpeg->feed(rgb24(image.value()))) return failed;
  }
  return ffmpeg && ffmpeg->end() ? Status() : Status(failed);
}

}  // namespace

bool is_animation_name(const fs::path& path) {
  return path.extension() == ".gif" || path.extension() == ".mp4";
}

bool has_ffmpeg() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && ::access((fs::path(folder) / "ffmpeg").c_str(), X_OK) == 0) return true;
  return false;
}

Status write_animation(const fs::path& path, const Animation& animation) {
  if (path.extension() == ".mp4") return write_mp4(path, animation);
  if (path.extension() != ".gif")
    return Error{ErrorCode::kUnsupported, "expected a name ending in .gif or .mp4", path.string()};
  const Result<const ImageLibrary*>& library = image_library();
  if (!library.ok()) return library.error();
  return library.value()->write_gif(path, animation);
}

}  // namespace qray
