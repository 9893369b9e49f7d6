#include "tests/crash/faults.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdlib>
#include <new>

#include "tests/support/sanitized.h"

namespace qray::test {
namespace {

std::atomic<bool> counts = false;

}  // namespace

void count_changes_here() { counts = true; }

FaultPlan& fault_plan() {
  static FaultPlan* const plan = [] {
    void* shared = ::mmap(nullptr, sizeof(FaultPlan), PROT_READ | PROT_WRITE,
                          MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) std::abort();
    return new (shared) FaultPlan;
  }();
  return *plan;
}

}  // namespace qray::test

// Sanitizers define these themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

using qray::test::Fault;
using qray::test::FaultPlan;

bool is_file(int fd) {
  struct stat info;
  return ::fstat(fd, &info) == 0 && (S_ISREG(info.st_mode) || S_ISDIR(info.st_mode));
}

bool is_line_to_database(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  return ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
         address.ss_family == AF_UNIX;
}

enum class What { kGoOn, kFail, kTear };

// Counts a change, and says what becomes of it.
What change(bool takes_room) {
  if (!qray::test::counts) return What::kGoOn;
  FaultPlan& plan = qray::test::fault_plan();
  if (!plan.armed) return What::kGoOn;
  const int64_t number = ++plan.changes;
  const int64_t at = plan.at;
  if (at == 0 || number < at) return What::kGoOn;
  const Fault fault = plan.fault;
  if (fault == Fault::kFullDisk) {
    errno = ENOSPC;
    return takes_room ? What::kFail : What::kGoOn;
  }
  if (number > at) return What::kGoOn;
  if (fault == Fault::kKill) ::kill(::getpid(), SIGKILL);
  if (fault == Fault::kTorn) return What::kTear;
  errno = EIO;
  return What::kFail;
}

[[noreturn]] void end() {
  ::kill(::getpid(), SIGKILL);
  for (;;) ::pause();
}

template <class... Args>
long simple(bool takes_room, long number, Args... args) {
  switch (change(takes_room)) {
    case What::kGoOn:
      return ::syscall(number, args...);
    case What::kFail:
      return -1;
    case What::kTear:
      end();
  }
  return -1;
}

int open_at(int folder, const char* path, int flags, mode_t mode) {
  const bool creates = (flags & O_CREAT) && ::faccessat(folder, path, F_OK, 0) != 0;
  if (!creates) return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
  return static_cast<int>(simple(true, SYS_openat, folder, path, flags, mode));
}

mode_t mode_of(int flags, va_list rest) {
  return (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, size_t size) {
  if (!is_file(fd)) return ::syscall(SYS_write, fd, bytes, size);
  switch (change(true)) {
    case What::kGoOn:
      return ::syscall(SYS_write, fd, bytes, size);
    case What::kFail:
      return -1;
    case What::kTear:
      ::syscall(SYS_write, fd, bytes, size / 2);
      end();
  }
  return -1;
}

ssize_t pwrite64(int fd, const void* bytes, size_t size, off64_t at) {
  switch (change(true)) {
    case What::kGoOn:
      return ::syscall(SYS_pwrite64, fd, bytes, size, at);
    case What::kFail:
      return -1;
    case What::kTear:
      ::syscall(SYS_pwrite64, fd, bytes, size / 2, at);
      end();
  }
  return -1;
}

ssize_t pwrite(int fd, const void* bytes, size_t size, off_t at) {
  return pwrite64(fd, bytes, size, at);
}

ssize_t writev(int fd, const iovec* parts, int count) {
  if (!is_file(fd)) return ::syscall(SYS_writev, fd, parts, count);
  return simple(true, SYS_writev, fd, parts, count);
}

ssize_t send(int fd, const void* bytes, size_t size, int flags) {
  const auto go_on = [&] { return ::syscall(SYS_sendto, fd, bytes, size, flags, nullptr, 0); };
  if (!is_line_to_database(fd)) return go_on();
  switch (change(false)) {
    case What::kGoOn:
      return go_on();
    case What::kFail:
      ::shutdown(fd, SHUT_RDWR);
      errno = ECONNRESET;
      return -1;
    case What::kTear:
      go_on();
      end();
  }
  return -1;
}

int fsync(int fd) { return static_cast<int>(simple(false, SYS_fsync, fd)); }
int fdatasync(int fd) { return static_cast<int>(simple(false, SYS_fdatasync, fd)); }
int syncfs(int fd) noexcept { return static_cast<int>(simple(false, SYS_syncfs, fd)); }
int ftruncate64(int fd, off64_t size) noexcept {
  return static_cast<int>(simple(false, SYS_ftruncate, fd, size));
}
int ftruncate(int fd, off_t size) noexcept { return ftruncate64(fd, size); }
int truncate(const char* path, off_t size) noexcept {
  return static_cast<int>(simple(false, SYS_truncate, path, size));
}
int rename(const char* from, const char* to) noexcept {
  return static_cast<int>(simple(true, SYS_rename, from, to));
}
int link(const char* from, const char* to) noexcept {
  return static_cast<int>(simple(true, SYS_link, from, to));
}
int unlink(const char* path) noexcept { return static_cast<int>(simple(false, SYS_unlink, path)); }
int unlinkat(int folder, const char* path, int flags) noexcept {
  return static_cast<int>(simple(false, SYS_unlinkat, folder, path, flags));
}
int rmdir(const char* path) noexcept { return static_cast<int>(simple(false, SYS_rmdir, path)); }
int remove(const char* path) noexcept {
  const int file = unlink(path);
  return file == 0 || errno != EISDIR ? file : rmdir(path);
}
int mkdir(const char* path, mode_t mode) noexcept {
  return static_cast<int>(simple(true, SYS_mkdir, path, mode));
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = mode_of(flags, rest);
  va_end(rest);
  return open_at(AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = mode_of(flags, rest);
  va_end(rest);
  return open_at(AT_FDCWD, path, flags, mode);
}

}  // extern "C"

#endif
