// A render's statistics, made of what its parts know. Pure functions.
#pragma once

#include "core/render/guide_decision.h"
#include "core/render/path.h"
#include "core/render/stats.h"

namespace qray {

// What the renderer could do and whether it does, at the start: RenderStats::parts.
std::map<std::string, std::string> render_parts(const PreparedScene& scene,
                                                const RenderSettings& settings,
                                                const LightPick& lights, const Guide* guide);

// How far a render came, and at what cost.
struct RenderTotals {
  uint64_t samples = 0, learning_samples = 0;  // a pixel, in complete passes
  double seconds = 0, noise = 0;
  int threads = 0;
  PathCounters counters;
};

// Guide and decision: null for method none.
RenderStats render_stats(const PreparedScene& scene, const RenderSettings& settings,
                         const RenderTotals& totals, const Guide* guide,
                         const GuideDecision* decision);

}  // namespace qray
