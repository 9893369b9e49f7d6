// The page of a chart's folder: one file without anything from elsewhere, read from a disk as well
// as from a server, on a phone or printed. One thread per folder.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/laboratory/chart/results.h"

namespace qray {

// Text for HTML, in attributes too.
std::string html_escape(std::string_view text);

// How a brightness differs from the reference's, in words: "2.8 times too bright", "0.4 % too
// dark".
std::string brightness_words(double ratio);

// Writes dir/index.html, which shows the plot and pictures that names.h and plot.h place in `dir`.
Status write_page(const ChartSummary& summary, const std::filesystem::path& dir);

}  // namespace qray
