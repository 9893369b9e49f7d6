#include "server/imports/import_child.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <thread>

#include "server/imports/check_scene.h"

extern char** environ;

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr size_t kMaxReportBytes = 1u << 20;
constexpr milliseconds kTick{20};  // between looks at `stop`

Error io_error(const char* doing, int error) {
  return {ErrorCode::kIo, std::string(doing) + ": " + std::strerror(error), "check-scene"};
}

class Child {
 public:
  static Result<Child> start(const std::string& program, std::vector<std::string> arguments) {
    int out[2];
    if (::pipe2(out, O_CLOEXEC) != 0) return io_error("no pipe", errno);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    char* nothing[] = {nullptr};
    char** environment = nothing;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    environment = environ;  // has the sanitizer's options
#endif
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    for (int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_RDWR, 0);
    posix_spawn_file_actions_adddup2(&files, out[1], CheckScene::kReportFd);
    posix_spawn_file_actions_addclosefrom_np(&files, CheckScene::kReportFd + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    Child child;
    child.out_ = out[0];
    const int error =
        ::posix_spawn(&child.pid_, program.c_str(), &files, &attributes, argv.data(), environment);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    ::close(out[1]);
    if (error == 0) return child;
    child.pid_ = 0;
    return io_error("no process", error);
  }
  Child(Child&& other) noexcept
      : pid_(std::exchange(other.pid_, 0)), out_(std::exchange(other.out_, -1)) {}
  Child& operator=(Child&&) = delete;
  ~Child() {
    if (out_ >= 0) ::close(out_);
    if (pid_ <= 0) return;
    ::kill(-pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

  // Appends what it has written. False: its end.
  bool read(std::string& text) const {
    pollfd p{out_, POLLIN, 0};
    if (::poll(&p, 1, static_cast<int>(kTick.count())) <= 0) return true;
    char block[16 * 1024];
    const ssize_t n = ::read(out_, block, sizeof block);
    if (n > 0) text.append(block, static_cast<size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
  }
  // How it ended, as waitpid gives it; none: it has not.
  std::optional<int> ended() {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
    pid_ = 0;
    return status;
  }

 private:
  Child() = default;
  pid_t pid_ = 0;
  int out_ = -1;
};

proto::SceneReport refusal(const ImportLimits& limits, const std::string& why) {
  proto::SceneReport report;
  report.error = proto::JobError{"it could not be read within " + std::to_string(limits.seconds) +
                                     " s and " + std::to_string(limits.memory_mib) + " MiB: " + why,
                                 ""};
  return report;
}

proto::SceneReport refusal(const ImportLimits& limits, int status) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == CheckScene::kOutOfMemory)
    return refusal(limits, "it takes more memory");
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
    return refusal(limits, "it takes more time");
  return refusal(limits, WIFSIGNALED(status) ? "the process that read it crashed"
                                             : "the process that read it gave up");
}

}  // namespace

Result<proto::SceneReport> read_upload(const ImportLimits& limits,
                                       const std::filesystem::path& folder,
                                       const std::string& entry, std::stop_token stop) {
  const CheckScene check{folder,
                         entry,
                         limits.memory_mib,
                         limits.seconds,
                         limits.unpacked_bytes,
                         limits.max_triangles,
                         ::getpid()};
  Result<Child> started = Child::start(limits.program, check.arguments());
  if (!started.ok()) return started.error();
  Child& child = started.value();
  const auto deadline = steady_clock::now() + std::chrono::seconds(limits.seconds);
  std::string text;
  bool writes = true;
  std::optional<int> status;
  while (writes || !status) {
    if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "the server stops", ""};
    if (steady_clock::now() > deadline) return refusal(limits, "it takes more time");
    if (text.size() > kMaxReportBytes) return refusal(limits, "it says too much");
    if (writes) {
      writes = child.read(text);
    } else if (!(status = child.ended())) {
      std::this_thread::sleep_for(kTick);
    }
  }
  if (WIFEXITED(*status) && WEXITSTATUS(*status) == 0)
    if (std::optional<proto::SceneReport> report = proto::parse_scene_report(text))
      return std::move(*report);
  return refusal(limits, *status);
}

}  // namespace qray::server
