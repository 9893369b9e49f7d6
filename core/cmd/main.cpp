#include "core/cmd/commands.h"

int main(int argc, char** argv) { return qray::cmd::run_command_line(argc, argv); }
