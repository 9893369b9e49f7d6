#include "server/operation/config.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>

#include "core/base/installed.h"
#include "server/store/picture.h"

namespace qray::server {
namespace {

// "max-queued" -> "QRAYD_MAX_QUEUED"
std::string variable_of(std::string name) {
  for (char& c : name) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return "QRAYD_" + name;
}

template <class T>
CLI::Option* add(CLI::App& app, const std::string& name, T& value, const char* what) {
  return app.add_option("--" + name, value, what)
      ->envname(variable_of(name))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
      ->capture_default_str();
}

void add_options(CLI::App& app, Config& c) {
  add(app, "host", c.host, "address to listen on");
  add(app, "port", c.port, "0 picks a free one and prints it")->check(CLI::Range(0, 65535));
  add(app, "data", c.data, "folder of jobs, tables and pictures");
  add(app, "store", c.store,
      "postgresql://... with the records of a farm; empty: SQLite in the data folder");
  add(app, "lease-seconds", c.lease_seconds,
      "that a silent worker of a farm keeps its jobs, before others take them")
      ->check(CLI::Range(1.0, 3600.0));
  add(app, "shared-pass-seconds", c.shared_pass_seconds,
      "a pass that would take less is not shared with other workers; 0: all are shared")
      ->check(CLI::Range(0.0, 3600.0));
  add(app, "scenes", c.scenes, "folder of scenes");
  add(app, "web", c.web, "folder of the page");
  add(app, "threads", c.threads, "of rendering; 0: one a processor")->check(CLI::Range(0, 1024));

  add(app, "tokens", c.tokens, "file of who may do what: see qrayd token");
  add(app, "names", c.names, "it may be called by without tokens, beside localhost")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--no-auth", c.no_auth,
               "any address and name without tokens, behind something that checks")
      ->envname(variable_of("no-auth"))
      ->default_str("false");

  add(app, "log-format", c.log_format, "lines of text, or of json")
      ->check(CLI::IsMember({"text", "json"}));
  add(app, "log-level", c.log_level, "debug has each request; info those with an error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}));
  add(app, "min-free-mib", c.min_free_mib, "of the data folder's disk; less, and /readyz says so")
      ->check(CLI::Range(0, 1 << 30));

  add(app, "json-mib", c.json_mib, "size of a body that is no asset")->check(CLI::Range(1, 64));
  add(app, "json-depth", c.json_depth, "levels of nesting in JSON")->check(CLI::Range(4, 128));
  add(app, "max-pixels", c.max_pixels, "of a job's picture")
      ->check(CLI::Range(int64_t{1}, kMaxPicturePixels));
  add(app, "max-job-seconds", c.max_job_seconds, "of rendering that a job may ask for")
      ->check(CLI::Range(1.0, 1e6));
  add(app, "max-queued", c.max_queued, "jobs that may wait")->check(CLI::Range(1, 100'000));
  add(app, "jobs-at-once", c.jobs_at_once,
      "jobs that share the render threads by their priorities; 0, of a front: others run them")
      ->check(CLI::Range(0, 64));
  add(app, "keep-days", c.keep_days,
      "after that an ended job and its picture are deleted; 0: never")
      ->check(CLI::Range(0.0, 36500.0));

  add(app, "max-connections", c.max_connections, "open at once")->check(CLI::Range(8, 900));
  add(app, "max-streams", c.max_streams, "event streams open at once")->check(CLI::Range(1, 900));
  add(app, "idle-seconds", c.idle_seconds, "a connection waits for its next request")
      ->check(CLI::Range(0.1, 3600.0));
  add(app, "head-seconds", c.head_seconds, "a request's head may take to arrive")
      ->check(CLI::Range(0.1, 3600.0));
  add(app, "body-seconds", c.body_seconds, "a body may be silent while it arrives")
      ->check(CLI::Range(0.1, 3600.0));

  add(app, "table-mib", c.table_mib, "memory of a job's table: full, it adds no states")
      ->check(CLI::Range(1, 1 << 19));
  add(app, "jobs-mib", c.jobs_mib,
      "memory of jobs and live sessions at once; jobs that do not fit wait")
      ->check(CLI::Range(1, 1 << 21));
  add(app, "scene-mib", c.scene_mib, "memory for loaded scenes that the next job may want")
      ->check(CLI::Range(0, 1 << 19));
  add(app, "max-triangles", c.max_triangles, "of a scene, an instanced mesh's once")
      ->check(CLI::Range(1, 1 << 30));
  add(app, "asset-mib", c.asset_mib, "size of one uploaded file")->check(CLI::Range(1, 1 << 14));
  add(app, "assets-gib", c.assets_gib, "disk that uploads may take together")
      ->check(CLI::Range(1, 1 << 20));
  add(app, "checkpoint-mib", c.checkpoint_mib,
      "disk for rendering more onto jobs that have succeeded")
      ->check(CLI::Range(0, 1 << 24));
  add(app, "moments-mib", c.moments_mib, "disk for the moments of jobs: pictures and tables")
      ->check(CLI::Range(0, 1 << 24));
  add(app, "import-mib", c.import_mib,
      "address space for reading an uploaded scene; 600 MiB of it are libraries")
      ->check(CLI::Range(1024, 1 << 20));
  add(app, "import-seconds", c.import_seconds, "time for reading an uploaded scene")
      ->check(CLI::Range(1, 3600));
  add(app, "unpacked-mib", c.unpacked_mib, "size of an uploaded zip's files")
      ->check(CLI::Range(1, 1 << 20));
  add(app, "imports", c.imports, "uploaded scenes that are read at once")->check(CLI::Range(1, 64));

  app.add_flag("--private-webhooks", c.private_webhooks,
               "webhooks may go to this machine and to networks of one's own")
      ->envname(variable_of("private-webhooks"))
      ->default_str("false");

  add(app, "live-sessions", c.live_sessions, "live sessions at once; each renders all the time")
      ->check(CLI::Range(0, 64));
  add(app, "live-idle-seconds", c.live_idle_seconds,
      "a live session without a camera or another call ends")
      ->check(CLI::Range(1.0, 86400.0));
}

// The environment as options before the command line's, which win as the last ones. (CLI11 itself
// would let the file win over the environment.)
std::vector<std::string> arguments(const CLI::App& app, int argc, const char* const* argv) {
  std::vector<std::string> args;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_envname().empty()) continue;
    if (const char* value = std::getenv(option->get_envname().c_str()))
      args.push_back("--" + option->get_lnames().front() + "=" + value);
  }
  args.insert(args.end(), argv + 1, argv + argc);
  std::reverse(args.begin(), args.end());  // as CLI11 takes them
  return args;
}

// Of an address: who logs in, and its parameters, are nobody's business.
std::string without_secrets(const std::string& address) {
  const size_t host = address.find("://");
  if (host == std::string::npos) return address.empty() ? "" : "...";
  const size_t user = address.rfind('@');
  const size_t from = user == std::string::npos ? host + 3 : user + 1;
  return address.substr(0, host + 3) + address.substr(from, address.find('?', from) - from);
}

std::vector<std::string> effective(const CLI::App& app) {
  std::vector<std::string> lines;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_configurable() || option->get_lnames().empty()) continue;
    const std::string value =
        option->empty() ? option->get_default_str() : option->as<std::string>();
    const std::string& name = option->get_lnames().front();
    lines.push_back(name + "=" + (name == "store" ? without_secrets(value) : value));
  }
  return lines;
}

// Of the machine, or of the control group (a container) that this process is in.
size_t memory_bytes() {
  size_t bytes =
      static_cast<size_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<size_t>(::sysconf(_SC_PAGESIZE));
  size_t limit = 0;  // "max" is no number
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit) bytes = std::min(bytes, limit);
  return bytes;
}

}  // namespace

Config default_config() {
  Config config;
  config.scenes = installed_or("scenes", QRAY_SCENES_DIR);
  config.web = installed_or("web", QRAY_WEB_DIR);
  config.web_lib = installed_or("web_lib", QRAY_WEB_LIB_DIR);
  config.openapi = installed_or("openapi.yaml", QRAY_OPENAPI_FILE);
  config.table_mib = std::clamp<size_t>(memory_bytes() / 16 >> 20, 1, 1 << 19);
  config.jobs_mib = 12 * config.table_mib;
  return config;
}

ParsedConfig parse_config(int argc, const char* const* argv) {
  Config config = default_config();
  CLI::App app("qrayd: the render service of qray", "qrayd");
  app.set_version_flag("--version", version_for_processor());
  app.set_config("--config", "", "a file of these options, as TOML")->envname("QRAYD_CONFIG");
  app.allow_config_extras(CLI::config_extras_mode::error);
  add_options(app, config);
  app.footer("qrayd token NAME SCOPE makes a token and its line for the file of --tokens.");
  try {
    app.parse(arguments(app, argc, argv));
    return {config, 0, effective(app)};
  } catch (const CLI::ParseError& e) {
    return {std::nullopt, app.exit(e), {}};
  }
}

}  // namespace qray::server
