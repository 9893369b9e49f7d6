#include "core/base/installed.h"

namespace qray {
namespace fs = std::filesystem;

fs::path beside_program(const fs::path& path, const fs::path& other) {
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  return ec ? other : beside_program(path, other, program.parent_path());
}

fs::path beside_program(const fs::path& path, const fs::path& other, const fs::path& bin) {
  const fs::path found = bin.parent_path() / path;
  std::error_code ec;
  return fs::exists(found, ec) ? found : other;
}

fs::path installed_or(std::string_view name, const fs::path& source) {
  return beside_program(fs::path("share/qray") / name, source);
}

}  // namespace qray
