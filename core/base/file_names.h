// Names of files that come from outside, in a manifest or an archive: relative, '/' between parts,
// the same file on every file system. One thread.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace qray {

class FileNames {
 public:
  static constexpr size_t kMost = 4096, kMaxBytes = 255, kMaxDepth = 8;

  // What is wrong with one more name; none: it is taken in.
  std::optional<std::string> add(std::string_view name);

 private:
  std::optional<std::string> clash(std::string_view name);
  // By their form in lower case, as some file systems compare: the name as it was given, and
  // whether it is of a file (else of a folder above one).
  struct Known {
    std::string name;
    bool is_file;
  };
  std::map<std::string, Known, std::less<>> known_;
  size_t files_ = 0;
};

}  // namespace qray
