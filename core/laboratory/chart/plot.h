// Draws error against seconds, both logarithmic, by gnuplot: per scene a panel, per method a line
// through the medians with a band from the least to the greatest seed. A line ends where it reaches
// the reference's floor, which is shaded; lines of biased methods are dashed, warm ones have hollow
// points. One thread per folder.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/laboratory/chart/results.h"

namespace qray {

// Writes chart.svg and chart.png (all scenes) and per scene <scene>/chart.svg below `dir`, and what
// they are drawn from, for anyone to draw again: chart.gp and chart.dat. These two are there even
// where gnuplot is not; the error then names its package.
Status write_plots(const ChartSummary& summary, const std::filesystem::path& dir);

}  // namespace qray
