#include "core/render/render_report.h"

#include <initializer_list>
#include <utility>

namespace qray {
namespace {

// Cycles of the paths that were timed, as shares of all.
void add_shares(const PathCounters& counters, RenderStats& stats) {
  if (counters.timed_total == 0) return;
  const double total = static_cast<double>(counters.timed_total);
  stats.share_tracing = static_cast<double>(counters.timed_tracing) / total;
  stats.share_guiding = static_cast<double>(counters.timed_guiding) / total;
  stats.share_rest = 1 - stats.share_tracing - stats.share_guiding;
}

}  // namespace

std::map<std::string, std::string> render_parts(const PreparedScene& scene,
                                                const RenderSettings& settings,
                                                const LightPick& lights, const Guide* guide) {
  const auto part = [](std::initializer_list<std::pair<bool, const char*>> reasons) {
    for (const auto& [off, why] : reasons)
      if (off) return std::string("off: ") + why;
    return std::string("on");
  };
  bool glossy = false;
  for (const MeshShading& mesh : scene.meshes)
    glossy |= mesh.kind != BsdfKind::kDiffuse && mesh.kind != BsdfKind::kDelta;
  const std::pair<bool, const char*> no_nee = {!settings.nee, "not asked for"},
                                     no_lights = {lights.empty(), "the scene has no lights"},
                                     even_sky = {!lights.connects(),
                                                 "the sky is even: paths find it by themselves"},
                                     no_guide = {!guide, "the method has no guide"};
  return {
      {"nee", part({no_nee, no_lights, even_sky})},
      {"light_table", part({{!settings.nee, "nee is off"},
                            no_lights,
                            even_sky,
                            {!settings.light_table, "not asked for"},
                            {lights.picks_uniformly(), "all lights are equally strong"}})},
      {"russian_roulette",
       part({{!settings.russian_roulette, "not asked for"},
             {settings.max_depth <= kRouletteFromDepth, "paths end before it begins"}})},
      {"guide", part({no_guide})},
      {"mixing", part({no_guide, {!glossy, "all surfaces that are guided are diffuse"}})},
  };
}

RenderStats render_stats(const PreparedScene& scene, const RenderSettings& settings,
                         const RenderTotals& totals, const Guide* guide,
                         const GuideDecision* decision) {
  RenderStats stats;
  stats.method = settings.method;
  stats.unbiased = !guide || guide->unbiased();
  stats.nee = settings.nee;
  stats.pixels = pixels_name(settings.pixels);
  stats.seed = settings.seed;
  stats.width = settings.width;
  stats.height = settings.height;
  stats.threads = totals.threads;
  stats.seconds = totals.seconds;
  stats.prepare_seconds = scene.seconds;
  stats.samples_per_pixel = totals.samples;
  stats.noise = totals.noise;
  stats.learning_samples_per_pixel = totals.learning_samples;
  stats.paths = totals.counters.paths;
  stats.rays = totals.counters.rays;
  stats.dropped_samples = totals.counters.dropped_samples;
  add_shares(totals.counters, stats);
  if (decision) stats.guide_passes = decision->passes();
  if (guide) {
    const GuideStats table = guide->stats();
    stats.states = table.states;
    stats.table_bytes = table.bytes;
    stats.table_samples_seen = table.samples_seen;
    stats.table_refused = table.refused;
  }
  return stats;
}

}  // namespace qray
