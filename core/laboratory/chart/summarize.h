// What a scene's runs say. Pure functions; any thread.
#pragma once

#include <span>

#include "core/laboratory/chart/results.h"

namespace qray {

// A measured error is a method's own plus, on average, the reference's. Below this many floors it
// says more of the reference than of the method: the point is marked, and nothing concluded of it.
constexpr double kFloorFactor = 2;

// The chance that a chart of methods without bias marks any as biased. Each of its series is judged
// at this over their number (Bonferroni).
constexpr double kBiasAlarm = 0.01;

// `rows`: of complete runs on one scene, in the order of measuring; methods keep that of their
// first rows. `series`: methods x scenes of the whole chart, cold and warm apart.
SceneSummary summarize_scene(const ChartReference& reference, std::span<const ChartRow> rows,
                             int series);

}  // namespace qray
