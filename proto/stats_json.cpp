#include "proto/stats_json.h"

#include "proto/json_text.h"

namespace qray::proto {

std::string stats_json(const RenderStats& stats, bool indent) {
  const JsonField fields[] = {
      {"method", stats.method},
      {"unbiased", stats.unbiased},
      {"nee", stats.nee},
      {"parts", stats.parts},
      {"seed", stats.seed},
      {"width", int64_t{stats.width}},
      {"height", int64_t{stats.height}},
      {"threads", int64_t{stats.threads}},
      {"seconds", stats.seconds},
      {"prepare_seconds", stats.prepare_seconds},
      {"samples", stats.samples_per_pixel},
      {"learning_samples", stats.learning_samples_per_pixel},
      {"passes", stats.passes},
      {"paths", stats.paths},
      {"rays", stats.rays},
      {"rays_per_second", stats.rays_per_second()},
      {"dropped_samples", stats.dropped_samples},
      {"states", uint64_t{stats.states}},
      {"table_bytes", uint64_t{stats.table_bytes}},
      {"table_samples_seen", stats.table_samples_seen},
      {"table_refused", stats.table_refused},
      {"share_tracing", stats.share_tracing},
      {"share_guiding", stats.share_guiding},
      {"share_rest", stats.share_rest},
  };
  return json_object(fields, indent);
}

}  // namespace qray::proto
