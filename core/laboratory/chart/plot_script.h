// The part of chart.gp that is the same for every chart. What differs is defined before it:
// all_columns (of panels), note, legend_columns_one, legend_columns_all, x_low, x_high; a series is
// a method, cold or warm: colour[], point[]; a scene: title[], folder[], floor[] (-1: not known),
// low[] and high[] of its error axis; label[] and dash[] as said there.
#pragma once

namespace qray {

extern const char* const kPlotScript;

}  // namespace qray
