// What qrayd is told: by a file (--config), the environment (QRAYD_<OPTION>) and its command line,
// where the later wins. docs/configuration.md lists every option.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace qray::server {

struct Config {
  std::string host = "127.0.0.1";
  int port = 8080;  // 0: any free one
  std::filesystem::path data = "data";
  std::string store;                  // postgresql://...; empty: SQLite in the data folder
  double lease_seconds = 15;          // that a silent worker of a shared store is believed
  double shared_pass_seconds = 0.25;  // a pass that takes less is not shared with other workers
  std::filesystem::path scenes, web;  // default: the source tree's
  std::filesystem::path web_lib;      // what the page takes from npm; may be absent
  std::filesystem::path openapi;      // the contract: the source tree's
  std::filesystem::path tokens;       // empty: nobody is asked for one
  std::vector<std::string> names;     // that it is called by without tokens, beside loopback's
  bool no_auth = false;               // so on any address, by any name
  std::string log_format = "text", log_level = "info";
  size_t min_free_mib = 256;  // of the data folder's disk; less, and /readyz says so
  int threads = 0;            // of rendering; 0: one a processor
  // Of requests.
  size_t json_mib = 4;  // of any body but an asset's
  int json_depth = 32;
  int64_t max_pixels = 4096LL * 4096;
  double max_job_seconds = 3600;  // that a job may ask for
  size_t max_queued = 1000;
  int jobs_at_once = 2;  // that share the render threads
  double keep_days = 0;  // jobs that have ended; 0: for ever
  // Of connections.
  size_t max_connections = 512;  // file numbers stay below FD_SETSIZE, which the library needs
  size_t max_streams = 256;
  double idle_seconds = 15, head_seconds = 5, body_seconds = 30;
  // Of memory and disk.
  size_t table_mib = 256;   // that a job's table may take
  size_t jobs_mib = 8192;   // that running jobs may take together
  size_t scene_mib = 2048;  // for scenes that the next job may want
  size_t max_triangles = 5'000'000;
  size_t asset_mib = 64;         // of one uploaded file
  size_t assets_gib = 4;         // of the disk, that uploads may take together
  size_t moments_mib = 2048;     // of disk, for how jobs came to be
  size_t checkpoint_mib = 2048;  // of disk, for going on with jobs that have succeeded
  // Of the process that reads an uploaded scene, and of what a zip unpacks to.
  size_t import_mib = 2048, import_seconds = 60, unpacked_mib = 1024;
  int imports = 1;                // such processes at once
  bool private_webhooks = false;  // may go to addresses that are not public
  // Of live sessions.
  size_t live_sessions = 4;                          // at once
  double live_idle_seconds = 300;                    // without a camera or another call
  std::filesystem::path program = "/proc/self/exe";  // qrayd, for these
};

// Default folders filled in, and of this machine's memory a sixteenth for a table, three quarters
// for all jobs and live sessions.
Config default_config();
// The configuration, or the exit code after --help or a wrong option was answered.
struct ParsedConfig {
  std::optional<Config> config;
  int exit_code = 0;
  std::vector<std::string> effective;  // "port=8080", each option in the order of --help
};
ParsedConfig parse_config(int argc, const char* const* argv);

}  // namespace qray::server
