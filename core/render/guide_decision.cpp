#include "core/render/guide_decision.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

// Measured, about: a vertex' lookup in the guide; a ray, from 36 triangles to 333,000.
constexpr double kLookupNs = 140;
double ray_ns(const PreparedScene& scene) {
  const auto triangles = static_cast<double>(scene.scene.placed_triangle_count());
  return 75 + 17 * std::max(0.0, std::log2(triangles / 36));
}

}  // namespace

GuideDecision::GuideDecision(const PreparedScene& scene, Guide& guide, bool open, bool view_lasts)
    : guide_(guide),
      view_lasts_(view_lasts),
      gate_(kLookupNs / ray_ns(scene), guide.stats().samples_seen > 0, open) {}

void GuideDecision::start_pass(uint64_t samples, bool may_learn) {
  learning_ = may_learn && gate_.learns();
  const bool guided = !guide_.expects() || gate_.guides(samples, guide_.stats().samples_seen);
  changing_ |= (guided && learning_) || guided != guided_;
  guided_ = guided;
}

void GuideDecision::judge(uint64_t samples, const PassCost& cost, const NoiseEstimate* noise) {
  const PassCost pass = cost - cost_;
  cost_ = cost;
  if (!guided_) gate_.unguided_pass(pass);
  GuidePass record{samples, guided_, learning_, 0, 0, 0, 0, 0};
  if (noise) {
    changing_ = false;
    record.variance = noise->variance();
    if (guided_ && guide_.expects() && gate_.on())
      record.efficiency_gain =
          gate_.guided_pass(samples, pass, noise->variance(), noise->unguided_variance());
    if (view_lasts_ && !gate_.grows()) guide_.stop_growing();
  }
  const GuideStats table = guide_.stats();
  record.states = table.states;
  record.direction_nodes = table.direction_nodes;
  record.table_bytes = table.bytes;
  passes_.push_back(record);
}

}  // namespace qray
