#include "core/base/installed.h"

#include <unistd.h>

namespace qray {
namespace fs = std::filesystem;
namespace {

#if defined(__AVX2__) && defined(__FMA__) && defined(__BMI2__)
constexpr bool kIsNewer = true;
#else
constexpr bool kIsNewer = false;
#endif

bool processor_is_newer() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

fs::path running_program() {
  std::error_code ec;
  return fs::read_symlink("/proc/self/exe", ec);
}

fs::path prefix_of(const fs::path& program) {
  fs::path prefix = program.parent_path();
  const fs::path newer(kNewerPrograms);
  for (auto part = newer.end(); part != newer.begin(); prefix = prefix.parent_path()) {
    if (prefix.filename() != *--part) return program.parent_path().parent_path();
  }
  return prefix;
}

}  // namespace

fs::path beside_program(const fs::path& path, const fs::path& other) {
  return beside_program(path, other, running_program());
}

fs::path beside_program(const fs::path& path, const fs::path& other, const fs::path& program) {
  const fs::path found = prefix_of(program) / path;
  std::error_code ec;
  return !program.empty() && fs::exists(found, ec) ? found : other;
}

fs::path installed_or(std::string_view name, const fs::path& source) {
  return beside_program(fs::path("share/qray") / name, source);
}

void run_program_of_processor(char** argv) {
  if (kIsNewer || !processor_is_newer()) return;
  const fs::path program = running_program();
  const fs::path newer = beside_program(kNewerPrograms / program.filename(), {});
  if (!newer.empty()) execv(newer.c_str(), argv);  // returns only where it cannot be run
}

std::string version_for_processor() {
  return std::string(QRAY_VERSION) + (kIsNewer ? " for x86-64-v3" : "");
}

}  // namespace qray
