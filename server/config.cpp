#include "server/config.h"

#include <CLI/CLI.hpp>

#include "core/base/installed.h"

namespace qray::server {

Config default_config() {
  Config config;
  config.scenes = installed_or("scenes", QRAY_SCENES_DIR);
  config.web = installed_or("web", QRAY_WEB_DIR);
  return config;
}

ParsedConfig parse_config(int argc, const char* const* argv) {
  Config config = default_config();
  CLI::App app("qrayd: the render service of qray", "qrayd");
  app.set_version_flag("--version", QRAY_VERSION);
  app.add_option("--host", config.host, "address to listen on")->capture_default_str();
  app.add_option("--port", config.port, "0 picks a free one and prints it")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--data", config.data, "folder of jobs, tables and pictures")
      ->capture_default_str();
  app.add_option("--threads", config.threads, "of rendering; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--scenes", config.scenes, "folder of scenes")->capture_default_str();
  app.add_option("--web", config.web, "folder of the page")->capture_default_str();
  app.add_option("--max-queued", config.max_queued, "jobs that may wait")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--jobs-at-once", config.jobs_at_once,
                 "jobs that share the render threads, by their priorities")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--checkpoint-mib", config.checkpoint_mib,
                 "disk for rendering more onto jobs that have succeeded")
      ->check(CLI::Range(0, 1 << 24))
      ->capture_default_str();
  app.add_option("--keep-days", config.keep_days,
                 "after that an ended job and its picture are deleted; 0: never")
      ->check(CLI::Range(0.0, 36500.0))
      ->capture_default_str();
  app.add_option("--table-mib", config.table_mib,
                 "memory of a job's table: full, it adds no states")
      ->check(CLI::Range(1, 1 << 19))
      ->capture_default_str();
  app.add_option("--scene-mib", config.scene_mib,
                 "memory for loaded scenes that the next job may want")
      ->check(CLI::Range(0, 1 << 19))
      ->capture_default_str();
  app.add_option("--asset-mib", config.asset_mib, "size of one uploaded file")
      ->check(CLI::Range(1, 1 << 14))
      ->capture_default_str();
  app.add_option("--assets-gib", config.assets_gib, "disk that uploads may take together")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  app.add_option("--import-mib", config.import_mib,
                 "address space for reading an uploaded scene; 600 MiB of it are libraries")
      ->check(CLI::Range(1024, 1 << 20))
      ->capture_default_str();
  app.add_option("--import-seconds", config.import_seconds, "time for reading an uploaded scene")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  app.add_option("--unpacked-mib", config.unpacked_mib, "size of an uploaded zip's files")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  app.add_option("--imports", config.imports, "uploaded scenes that are read at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return {std::nullopt, app.exit(e)};
  }
  return {config, 0};
}

}  // namespace qray::server
