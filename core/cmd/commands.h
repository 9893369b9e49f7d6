// The subcommands of qray: each add_* declares one with its options and stores the exit code of
// running it. One thread.
#pragma once

namespace CLI {
class App;
}

namespace qray::cmd {

// What scripts may rely on; printed by `qray --help`.
enum ExitCode : int {
  kExitOk = 0,
  kExitBadInput = 1,  // command line, file, scene or request
  kExitJobFailed = 2,
  kExitCanceled = 3,     // by Ctrl-C here, or on the server
  kExitUnreachable = 4,  // no server there, or it broke off
  kExitNotNow = 5,       // the server is full, or --timeout has passed
};

void add_render(CLI::App& app, int& exit_code);
void add_diff(CLI::App& app, int& exit_code);
void add_table(CLI::App& app, int& exit_code);
void add_recover(CLI::App& app, int& exit_code);
void add_scene(CLI::App& app, int& exit_code);
void add_chart(CLI::App& app, int& exit_code);
void add_live(CLI::App& app, int& exit_code);
void add_thesis(CLI::App& app, int& exit_code);
void add_submit(CLI::App& app, int& exit_code);
void add_watch(CLI::App& app, int& exit_code);
void add_wait(CLI::App& app, int& exit_code);
void add_job_actions(CLI::App& app, int& exit_code);  // cancel, pause, resume, extend, log
void add_fetch(CLI::App& app, int& exit_code);

// Runs one command line and returns its exit code.
int run_command_line(int argc, const char* const* argv);

}  // namespace qray::cmd
