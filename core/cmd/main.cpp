#include "core/base/installed.h"
#include "core/cmd/commands.h"

int main(int argc, char** argv) {
  qray::run_program_of_processor(argv);
  return qray::cmd::run_command_line(argc, argv);
}
