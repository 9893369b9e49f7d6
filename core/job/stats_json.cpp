#include "core/job/stats_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace qray {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson known(double v) { return v > 0 ? OrderedJson(v) : OrderedJson(); }

OrderedJson guide_pass(const GuidePass& p) {
  return {{"samples", p.samples},
          {"guided", p.guided},
          {"learned", p.learned},
          {"share", p.share},
          {"variance", known(p.variance)},
          {"efficiency_gain", known(p.efficiency_gain)},
          {"states", p.states},
          {"direction_nodes", p.direction_nodes},
          {"table_bytes", p.table_bytes}};
}

}  // namespace

std::string stats_json(const RenderStats& stats, bool indent) {
  OrderedJson passes = OrderedJson::array();
  for (const GuidePass& p : stats.guide_passes) passes.push_back(guide_pass(p));
  OrderedJson all = {
      {"method", stats.method},
      {"unbiased", stats.unbiased},
      {"nee", stats.nee},
      {"parts", stats.parts},
      {"seed", stats.seed},
      {"width", stats.width},
      {"height", stats.height},
      {"threads", stats.threads},
      {"light_groups", stats.light_groups},
      {"pixels", stats.pixels},
      {"recovery", stats.recovery},
      {"recovery_seconds", stats.recovery_seconds},
      {"recovery_held_pixels", stats.recovery_held_pixels},
      {"picture_passes_seconds", stats.picture_passes_seconds},
      {"seconds", stats.seconds},
      {"prepare_seconds", stats.prepare_seconds},
      {"samples", stats.samples_per_pixel},
      {"noise", known(stats.noise)},
      {"learning_samples", stats.learning_samples_per_pixel},
      {"passes", stats.passes},
      {"last_pass_tiles", stats.last_pass_tiles},
      {"pilot_samples", stats.pilot_samples},
      {"paths", stats.paths},
      {"rays", stats.rays},
      {"rays_per_second", stats.rays_per_second()},
      {"dropped_samples", stats.dropped_samples},
      {"states", stats.states},
      {"table_bytes", stats.table_bytes},
      {"table_samples_seen", stats.table_samples_seen},
      {"table_refused", stats.table_refused},
      {"guide_passes", passes},
      {"mixed_builds", stats.mixed_builds},
      {"share_tracing", stats.share_tracing},
      {"share_guiding", stats.share_guiding},
      {"share_rest", stats.share_rest},
  };
  if (stats.frames > 1) all["frames"] = stats.frames;
  return indent ? all.dump(2) + "\n" : all.dump();
}

}  // namespace qray
