// The inside of the process that reads an upload: `qrayd check-scene`, started by ImportChild and
// by nobody else. It unpacks, loads and prepares the scene under limits of its own, and writes one
// line of JSON to file number 3.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace qray::server {

struct CheckScene {
  std::filesystem::path folder;  // "upload.zip" in it is unpacked into "files", or that is there
  std::string entry;             // of the files; empty: to be found
  uint64_t memory_mib = 0, seconds = 0, unpacked_bytes = 0, max_triangles = 0;
  int parent = 0;  // the process that asks: without it, this one ends

  static constexpr int kReportFd = 3;
  static constexpr int kOutOfMemory = 77;  // exit code
  static constexpr const char* kCommand = "check-scene";

  std::vector<std::string> arguments() const;  // as main() gets them
  static std::optional<CheckScene> parse(int argc, const char* const* argv);
};

// The exit code.
int check_scene(const CheckScene& check);

}  // namespace qray::server
