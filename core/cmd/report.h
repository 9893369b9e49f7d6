// How the command tells errors: one line on stderr, and an exit code. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/cmd/commands.h"

namespace qray::cmd {

// Prints "qray: where: message" and returns the exit code for it.
int report(const Error& error);

}  // namespace qray::cmd
