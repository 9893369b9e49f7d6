#include "core/render/render_loop.h"

namespace qray {

Status step_render(Renderer& renderer, const Guide* guide, RenderObserver& observer,
                   const std::stop_token& stop, Checkpointer* keeper, const WriteState& write,
                   PassSampler* sampler) {
  const Error canceled{ErrorCode::kCanceled, "canceled", ""};
  const auto due = [&] { return keeper && keeper->due(); };
  const auto pause = [&] { return due() || renderer.out_of_time(); };
  while (renderer.in_pass() || renderer.start_pass()) {
    while (renderer.units_left() > 0 && !renderer.out_of_time()) {
      if (!sampler)
        renderer.sample(renderer.units_left(), pause, stop, observer);
      else if (Status s = sampler->sample(renderer, pause, stop, observer); !s.ok())
        return s;
      if (stop.stop_requested()) return canceled;
      if (due() && !keeper->save(write)) return canceled;
    }
    if (!renderer.pass_whole()) break;
    renderer.end_pass();
    observer.on_pass(renderer.progress(), renderer.stats(), guide);
  }
  return {};
}

Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock, const Checkpoints& checkpoints,
                           PassSampler* sampler) {
  Renderer renderer(scene, settings, guide, film, pool, clock);
  if (SnapshotReader* in = checkpoints.resume_from) {
    const bool fits = renderer.load_state(*in);
    if (fits && guide) guide->load_state(*in);
    if (!fits || !in->whole())
      return Error{ErrorCode::kCorrupt, "not a state of this render", "checkpoint"};
  } else if (const auto pilot = render_pilot(scene, settings, guide, pool, clock, stop)) {
    renderer.begin_after(*pilot);
  }
  const WriteState write = [&](SnapshotWriter& out) {
    renderer.save_state(out);
    if (guide) guide->save_state(out);
  };
  const Status stepped =
      step_render(renderer, guide, observer, stop, checkpoints.keeper, write, sampler);
  if (!stepped.ok()) return stepped.error();
  if (checkpoints.keeper) (void)checkpoints.keeper->save(write);  // more may be added some day
  return renderer.stats();
}

}  // namespace qray
