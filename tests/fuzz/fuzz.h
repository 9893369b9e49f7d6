// What the fuzz targets share: a folder in memory for what is read from files, and what must hold
// after any input. A broken promise is a QRAY_CHECK, which the fuzzer reports as a crash.
#pragma once

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "core/base/check.h"
#include "core/base/result.h"
#include "tests/support/scratch.h"

namespace qray::fuzz {

inline void expect_said_why(const Error& error) {
  QRAY_CHECK(!error.message.empty());
  QRAY_CHECK(!error.where.empty());
}

inline std::string_view as_text(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// One a process. It stays when the process crashes: a few KB.
class Folder {
 public:
  Folder() : scratch_(in_memory()) {}

  std::filesystem::path write(const std::string& name, std::string_view text) const {
    std::ofstream out(scratch_ / name, std::ios::binary);
    out << text;
    QRAY_CHECK(out.flush().good());
    return scratch_ / name;
  }
  void add(const std::string& file_of_project, const std::string& name) const {
    std::filesystem::copy(QRAY_SOURCE_DIR "/" + file_of_project, scratch_ / name);
  }
  // A mesh, a picture and a sky for scenes to name.
  void add_schema_corpus() const {
    for (const std::string name : {"triangle.obj", "triangle.ply", "checker.ppm", "sky.hdr"})
      add("tests/schema/corpus/" + name, name);
  }

 private:
  static std::filesystem::path in_memory() {
    std::error_code ignored;
    const std::filesystem::path shared = "/dev/shm";
    return std::filesystem::is_directory(shared, ignored) ? shared
                                                          : std::filesystem::temp_directory_path();
  }
  test::ScratchFolder scratch_;
};

}  // namespace qray::fuzz
