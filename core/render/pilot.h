// A pilot: a small picture of a job's view, rendered before the job's own and thrown away. It tells
// what paths cost without the guide and how noisy they are, and the guide learns from it. So the
// job's picture is guided from its first sample on where there is much noise, and learns from few
// of its pixels where there is little (guide_gate.h). A pilot counts samples and not time, so that
// the same settings and table have the same pilot; but in a job bounded by time it ends once it has
// had its share of that, and what it would have learned the picture's own first pass teaches.
#pragma once

#include <optional>
#include <stop_token>

#include "core/base/clock.h"
#include "core/base/task_pool.h"
#include "core/render/guide_gate.h"
#include "core/render/path.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

struct Pilot {
  GuideGate gate;  // as the job's begins
  PathCounters counters;
  int samples = 0;  // a pixel of its own
};

// None: it was stopped, or there is nothing to find out. That is so without a guide that expects
// and may learn, with an open gate, with a table that paid before, and in small pictures.
std::optional<Pilot> render_pilot(const PreparedScene& scene, const RenderSettings& settings,
                                  Guide* guide, TaskPool& pool, const Clock& clock,
                                  const std::stop_token& stop);

}  // namespace qray
