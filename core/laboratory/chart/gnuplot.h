// Runs Debian's gnuplot as a child process, without a shell and without anyone's startup files.
// Any thread.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace qray {

// Runs `script`, a file in `folder`, with `folder` as the current one. An error has what gnuplot
// said; kNotFound names the package when gnuplot is not installed.
Status run_gnuplot(const std::filesystem::path& folder, const std::string& script);

}  // namespace qray
