#include "core/laboratory/chart/gnuplot.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

extern char** environ;

namespace qray {
namespace {

constexpr int kSilentMs = 60'000;  // a chart takes about a second
constexpr size_t kMaxSaid = 2000;

// Starts it with its messages going to `say_fd`; an errno value, 0 if all is well.
int start(pid_t& pid, const std::filesystem::path& folder, std::string script, int say_fd) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, say_fd, STDERR_FILENO);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  char program[] = "gnuplot", no_startup_files[] = "-d";
  char* argv[] = {program, no_startup_files, script.data(), nullptr};
  const int failure = ::posix_spawnp(&pid, program, &actions, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  return failure;
}

// What the child says until it closes its end; ends a child that hangs.
std::string listen(int fd, pid_t pid) {
  std::string said;
  char block[512];
  for (;;) {
    pollfd ready{fd, POLLIN, 0};
    const int count = ::poll(&ready, 1, kSilentMs);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      ::kill(pid, SIGKILL);
      return said + "nothing for a minute; it was ended";
    }
    const ssize_t n = ::read(fd, block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return said;
    if (said.size() < kMaxSaid) said.append(block, static_cast<size_t>(n));
  }
}

}  // namespace

Status run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
  int pipe_fds[2];
  if (::pipe2(pipe_fds, O_CLOEXEC) != 0) {
    return Error{ErrorCode::kIo, std::string("cannot make a pipe: ") + std::strerror(errno), ""};
  }
  pid_t pid = 0;
  const int failure = start(pid, folder, script, pipe_fds[1]);
  ::close(pipe_fds[1]);
  const std::string said = failure == 0 ? listen(pipe_fds[0], pid) : "";
  ::close(pipe_fds[0]);
  if (failure == ENOENT && std::filesystem::is_directory(folder)) {
    return Error{ErrorCode::kNotFound,
                 "gnuplot is not installed: apt-get install gnuplot-nox, then run gnuplot on this",
                 (folder / script).string()};
  }
  if (failure != 0) {
    return Error{ErrorCode::kIo, std::string("cannot start gnuplot: ") + std::strerror(failure),
                 folder.string()};
  }
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return Error{ErrorCode::kIo, "gnuplot failed, saying: " + said, (folder / script).string()};
}

}  // namespace qray
