// What qrayd is told on its command line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace qray::server {

struct Config {
  std::string host = "127.0.0.1";
  int port = 8080;  // 0: any free one
  std::filesystem::path data = "data";
  std::filesystem::path scenes, web;  // default: the source tree's
  int threads = 0;                    // of rendering; 0: one a processor
  int jobs_at_once = 2;
  size_t max_queued = 1000;
  size_t checkpoint_mib = 2048;  // of disk, for going on with jobs that have succeeded
  double keep_days = 0;          // jobs that have ended; 0: for ever
  size_t table_mib = 256;        // of memory, that a job's table may take
  size_t scene_mib = 2048;       // of memory, for scenes that the next job may want
  size_t asset_mib = 64;         // of one uploaded file
  size_t assets_gib = 4;         // of the disk, that uploads may take together
  // Of the process that reads an uploaded scene, and of what a zip unpacks to.
  size_t import_mib = 2048, import_seconds = 60, unpacked_mib = 1024;
  int imports = 1;                                   // such processes at once
  std::filesystem::path program = "/proc/self/exe";  // qrayd, for these
};

// Default folders filled in.
Config default_config();
// The configuration, or the exit code after --help or a wrong option was answered.
struct ParsedConfig {
  std::optional<Config> config;
  int exit_code = 0;
};
ParsedConfig parse_config(int argc, const char* const* argv);

}  // namespace qray::server
