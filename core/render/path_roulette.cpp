// Russian roulette.
#include <algorithm>
#include <cmath>

#include "core/base/cycle_clock.h"
#include "core/render/path.h"

namespace qray {
namespace {

constexpr float kLeastSurvival = 0.05f;
constexpr float kMostSurvival = 0.95f;  // by throughput
// The root of the cost of a path so far over that of its going on, were noises known exactly (Rath
// et al. 2022); they are not: see docs/measurements/guiding.md.
constexpr float kRouletteFactor = 4;

}  // namespace

// Not at panes: a path of fewer surfaces meets the last one without.
uint32_t PathTracer::survive(uint32_t lanes) {
  uint32_t playing = lanes;
  for_each_lane(lanes & ~vertex_.lambert, [&](int lane) {
    if (vertex_.is_delta(lane) && scene_.meshes[vertex_.hit.mesh[index(lane)]].pane)
      playing &= ~(1u << lane);
  });
  uint32_t ended = end_by_throughput(playing & ~path_.with_guide);
  for_each_lane(playing & path_.with_guide, [&](int lane) {
    if (!survive(lane)) ended |= 1u << lane;
  });
  return lanes & ~ended;
}

// What survive() comes to without a guide. What comes back are the lanes whose paths end.
uint32_t PathTracer::end_by_throughput(uint32_t lanes) {
  if (!settings_.russian_roulette) return 0;
  uint32_t deep = 0;
  for_each_lane(lanes, [&](int lane) {
    if (path_.depth[index(lane)] >= kRouletteFromDepth) deep |= 1u << lane;
  });
  if (deep == 0) return 0;
  const WideRgb throughput = path_.throughput.wide();
  const WideRgb brings =
      throughput * (path_.eta_scale.wide() * max(wide(1), path_.guidance.wide()));
  const Wide chance = min(wide(kMostSurvival), max(max(brings.r, brings.g), brings.b));
  const WideInt plays = mask_of(deep);
  const uint32_t ended = deep & ~lanes_of(vertex_.u.d.x.wide() < chance);
  const Wide survivors = plays ? 1 / chance : wide(1);
  path_.survival_chance = path_.survival_chance.wide() * (plays ? chance : wide(1));
  path_.throughput = throughput * survivors;
  return ended;
}

bool PathTracer::survive(int lane) {
  const Survival survival = this->survival(lane);
  const Rgb throughput = path_.throughput[lane];
  float unguided_chance = 1;
  if (learner(lane).on()) {
    unguided_chance = this->unguided_chance(
        path_.depth[index(lane)],
        throughput * (path_.eta_scale[lane] * path_.guidance[lane] * path_.survival_chance[lane] /
                      path_.unguided_survival_chance[lane]));
    path_.unguided_survival_chance[lane] *= unguided_chance;
  }
  if (survival.chance < 1) {
    const Rgb control = throughput * survival.control;
    // It stands for light of the next surface and of those behind it.
    const auto pay = [&](Rgb light) {
      path_.radiance.set(lane, path_.radiance[lane] + light);
      if (split_ && split_->layers.bounces > 0)
        paid_[index(lane)].push_back({split_->layers.bounce(path_.depth[index(lane)] + 1), light});
    };
    if (!(vertex_.u.d.x[lane] < survival.chance)) {
      pay(control);
      return false;
    }
    const float survivors = 1 / survival.chance;
    path_.survival_chance[lane] *= survival.chance;
    pay(control * (1 - survivors));
    path_.throughput.set(lane, throughput * survivors);
  }
  learner(lane).survived(!vertex_.is_delta(lane), survival.chance, survival.control,
                         unguided_chance);
  return true;
}

// Where the table is credible, by the noise that what follows would bring into the pixel, with the
// table's expectation of what the base sends on as control variate (after Rath et al. 2022, "EARS",
// and Mueller et al. 2020, "Neural Control Variates"); else by throughput from some depth on. Lobes
// have no control variate: their whole second moment counts. Nor has any light that is kept by
// groups, of which the table knows nothing.
PathTracer::Survival PathTracer::survival(int lane) {
  const Rgb throughput = path_.throughput[lane];
  const Guiding guiding = path_.guiding[index(lane)];
  const bool asks = guide_expects_ && guiding != Guiding::kOff;
  if (const BsdfParts parts = asks ? parts_at(lane) : BsdfParts{}; asks && parts.base_chance > 0) {
    const CycleScope scope(timed_, counters_.timed_guiding);
    const GuideExpectation expected = guide_->expectation(vertex_.in_guide[index(lane)]);
    if (expected.credible) {
      const Rgb control = parts.base_albedo * expected.arriving;
      if (learner(lane).on()) learner(lane).expected(control);
      if (guiding == Guiding::kOn) {
        if (!settings_.russian_roulette) return {};
        const float arriving = luminance(expected.arriving);
        const float of_base =
            luminance(throughput * parts.base_albedo) *
            (has_groups() ? std::hypot(arriving, expected.deviation) : expected.deviation);
        const float of_lobes = parts.lobes_albedo.is_black()
                                   ? 0.0f
                                   : luminance(throughput * parts.lobes_albedo) *
                                         std::hypot(arriving, expected.deviation);
        const float noise = of_base + of_lobes;
        const uint32_t bit = 1u << lane;
        if (path_.pixel_deviation[lane] == 0) {
          path_.pixel_deviation[lane] = noise;
          path_.deviation_guessed |= bit;
        }
        if (!(path_.pixel_deviation[lane] > 0)) return {};
        const float chance = kRouletteFactor * noise / path_.pixel_deviation[lane];
        // A guess may be far off: without a control variate black pixels stay black.
        return {std::clamp(chance, kLeastSurvival, 1.0f),
                path_.deviation_guessed & bit || has_groups() ? Rgb{} : control};
      }
    }
  }
  // A path that was guided to light has little throughput, and so has one in glass: that is no
  // reason to end it.
  return {
      unguided_chance(path_.depth[index(lane)],
                      throughput * (path_.eta_scale[lane] * std::max(1.0f, path_.guidance[lane]))),
      {}};
}

float PathTracer::unguided_chance(int depth, Rgb throughput) const {
  if (!settings_.russian_roulette || depth < kRouletteFromDepth) return 1;
  return std::min(kMostSurvival, max_component(throughput));
}

}  // namespace qray
