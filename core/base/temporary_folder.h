// A new folder with a name of its own, which goes with this and takes along what is in it. One
// thread.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace qray {

class TemporaryFolder {
 public:
  // In `parent`, which is made where it is not there; its name begins with `prefix`.
  TemporaryFolder(const std::filesystem::path& parent, const std::string& prefix) {
    std::error_code ec;
    std::filesystem::create_directories(parent, ec);
    std::string name = (parent / (prefix + "XXXXXX")).string();
    if (::mkdtemp(name.data())) path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ec;
    if (ok()) std::filesystem::remove_all(path_, ec);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  bool ok() const { return !path_.empty(); }  // false: it could not be made
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace qray
