// Russian roulette.
#include <cstring>

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
  const uint32_t guided = playing & path_.with_guide;
  // A path that was guided to light has little throughput, and so has one in glass: that is no
  // reason to end it.
  Wide chance = chance_by_throughput(path_.eta_scale.wide() * max(wide(1), path_.guidance.wide()));
  RgbLanes control;
  uint32_t by_noise = 0;
  if (guided && guide_expects_) by_noise = survive_by_noise(guided, chance, control);
  uint32_t learned = 0;
  for_each_lane(guided, [&](int lane) {
    if (learner(lane).on()) learned |= 1u << lane;
  });
  FloatLanes unguided;
  if (learned) {
    const Wide without = path_.unguided_survival_chance.wide();
    const Wide q = chance_by_throughput(path_.eta_scale.wide() * path_.guidance.wide() *
                                        path_.survival_chance.wide() / without);
    unguided = q;
    path_.unguided_survival_chance = mask_of(learned) ? without * q : without;
  }

  const WideInt plays = mask_of(playing) & (chance < 1);
  const uint32_t ended = lanes_of(plays & ~(vertex_.u.d.x.wide() < chance));
  const Wide survivors = plays ? 1 / chance : wide(1);
  const WideRgb throughput = path_.throughput.wide();
  if (const uint32_t paid = by_noise & lanes_of(plays)) {
    const WideInt pays = mask_of(paid);
    const Wide share = mask_of(ended) ? wide(1) : 1 - survivors;
    RgbLanes light;
    light = throughput * control.wide() * share;
    const auto add = [&](FloatLanes& to, const FloatLanes& more) {
      to = pays ? to.wide() + more.wide() : to.wide();
    };
    add(path_.radiance.r, light.r);
    add(path_.radiance.g, light.g);
    add(path_.radiance.b, light.b);
    // It stands for light of the next surface and of those behind it.
    if (split_ && split_->layers.bounces > 0) {
      for_each_lane(paid, [&](int lane) {
        const int bounce = split_->layers.bounce(path_.depth[index(lane)] + 1);
        paid_[index(lane)].push_back({bounce, light[lane]});
      });
    }
  }
  path_.survival_chance = path_.survival_chance.wide() * (plays ? chance : wide(1));
  path_.throughput = throughput * survivors;
  if (learned) {
    FloatLanes chances;
    chances = chance;
    for_each_lane(learned & ~ended, [&](int lane) {
      const Rgb paid = by_noise >> lane & 1 ? control[lane] : Rgb{};
      learner(lane).survived(!vertex_.is_delta(lane), chances[lane], paid, unguided[lane]);
    });
  }
  return lanes & ~ended;
}

// Of throughput times `scale`, from some depth on.
Wide PathTracer::chance_by_throughput(const Wide& scale) const {
  if (!settings_.russian_roulette) return wide(1);
  WideInt depth;
  static_assert(sizeof depth == sizeof path_.depth);
  std::memcpy(&depth, path_.depth.data(), sizeof depth);
  const WideRgb brings = path_.throughput.wide() * scale;
  const Wide chance = min(wide(kMostSurvival), max(max(brings.r, brings.g), brings.b));
  return depth >= kRouletteFromDepth ? chance : wide(1);
}

// Where the table is credible, by the noise that what follows would bring into the pixel, with the
// table's expectation of what the base sends on as control variate (after Rath et al. 2022, "EARS",
// and Mueller et al. 2020, "Neural Control Variates"); else `chance` stays. Lobes have no control
// variate: their whole second moment counts. Nor has any light that is kept by groups, of which the
// table knows nothing. What comes back are the lanes with a control variate.
uint32_t PathTracer::survive_by_noise(uint32_t lanes, Wide& chance, RgbLanes& control) {
  const CycleScope scope(timed_, counters_.timed_guiding);
  RgbLanes base = vertex_.reflectance, lobes;
  uint32_t asking = 0, on = 0, with_lobes = 0;
  for_each_lane(lanes, [&](int lane) {
    const Guiding guiding = path_.guiding[index(lane)];
    if (guiding == Guiding::kOff) return;
    const uint32_t bit = 1u << lane;
    if (!(vertex_.lambert & bit)) {
      const BsdfParts& parts = vertex_.at(lane).parts;
      if (!(parts.base_chance > 0)) return;
      base.set(lane, parts.base_albedo);
      if (!parts.lobes_albedo.is_black()) {
        lobes.set(lane, parts.lobes_albedo);
        with_lobes |= bit;
      }
    }
    asking |= bit;
    if (guiding == Guiding::kOn) on |= bit;
  });
  if (asking == 0) return 0;
  ExpectationLanes& expected = vertex_.expected;
  const uint32_t credible = guide_->expect_each(vertex_.in_guide, asking, expected);
  control = base.wide() * expected.arriving.wide();
  for_each_lane(credible, [&](int lane) {
    if (learner(lane).on()) learner(lane).expected(control[lane]);
  });
  on &= credible;
  if (on == 0 || !settings_.russian_roulette) return 0;

  const WideRgb throughput = path_.throughput.wide();
  const Wide arriving = luminance(expected.arriving.wide()), deviation = expected.deviation.wide();
  const Wide moment = sqrt(arriving * arriving + deviation * deviation);
  Wide noise = luminance(throughput * base.wide()) * (has_groups() ? moment : deviation);
  if (with_lobes)
    noise += mask_of(with_lobes) ? luminance(throughput * lobes.wide()) * moment : Wide{};
  const Wide known = path_.pixel_deviation.wide();
  const WideInt unknown = mask_of(on) & (known == 0);
  const Wide of_pixel = unknown ? noise : known;
  path_.pixel_deviation = of_pixel;
  path_.deviation_guessed |= lanes_of(unknown);
  const WideInt plays = mask_of(on) & (of_pixel > 0);
  const Wide wanted = kRouletteFactor * noise / of_pixel;
  const Wide raised = wanted < kLeastSurvival ? wide(kLeastSurvival) : wanted;
  chance = plays ? (raised > 1 ? wide(1) : raised) : mask_of(on) ? wide(1) : chance;
  // A guess may be far off: without a control variate black pixels stay black.
  return has_groups() ? 0 : lanes_of(plays) & ~path_.deviation_guessed;
}

}  // namespace qray
