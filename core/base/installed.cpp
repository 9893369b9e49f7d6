#include "core/base/installed.h"

namespace qray {
namespace fs = std::filesystem;

fs::path installed_or(std::string_view name, const fs::path& source) {
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  return ec ? source : installed_or(name, source, program.parent_path());
}

fs::path installed_or(std::string_view name, const fs::path& source, const fs::path& bin) {
  const fs::path installed = bin.parent_path() / "share" / "qray" / name;
  std::error_code ec;
  return fs::exists(installed, ec) ? installed : source;
}

}  // namespace qray
