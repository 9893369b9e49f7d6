#include "server/operation/process_limits.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>

namespace qray::server {
namespace {

constexpr size_t kOtherFiles = 64;  // the database, files of jobs and uploads
constexpr size_t kFewest = 8;

}  // namespace

void survive_limits() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

size_t connections_within_limits(size_t wanted) {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return wanted;
  const rlim_t needed = wanted + kOtherFiles;
  if (files.rlim_cur < needed) {
    files.rlim_cur = std::min<rlim_t>(files.rlim_max, needed);
    ::setrlimit(RLIMIT_NOFILE, &files);
    ::getrlimit(RLIMIT_NOFILE, &files);
  }
  if (files.rlim_cur >= needed) return wanted;
  const size_t room = std::max<size_t>(files.rlim_cur, kOtherFiles + kFewest) - kOtherFiles;
  spdlog::warn("{} connections instead of {}: the system allows {} open files (ulimit -n)", room,
               wanted, files.rlim_cur);
  return room;
}

}  // namespace qray::server
