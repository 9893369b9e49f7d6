#include "core/cmd/commands.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "core/base/installed.h"

namespace qray::cmd {

int run_command_line(int argc, const char* const* argv) {
  CLI::App app{"qray: path tracing that learns where the light is"};
  app.set_version_flag("--version", version_for_processor());
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done; 1 wrong command line, file, scene or request; 2 the job failed;\n"
      "3 canceled; 4 no server there, or it broke off; 5 server full, or --timeout has passed.");

  int exit_code = kExitOk;
  add_render(app, exit_code);
  add_diff(app, exit_code);
  add_table(app, exit_code);
  add_recover(app, exit_code);
  add_scene(app, exit_code);
  add_chart(app, exit_code);
  add_live(app, exit_code);
  add_thesis(app, exit_code);
  add_submit(app, exit_code);
  add_watch(app, exit_code);
  add_wait(app, exit_code);
  add_job_actions(app, exit_code);
  add_fetch(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : kExitBadInput;
  } catch (const std::exception& e) {  // no memory, and what a library throws
    std::fprintf(stderr, "qray: %s\n", e.what());
    return kExitBadInput;
  }
  return exit_code;
}

}  // namespace qray::cmd
