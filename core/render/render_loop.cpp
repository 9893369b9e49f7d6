#include "core/render/render_loop.h"

#include "core/render/renderer.h"

namespace qray {

Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock,
                           const Checkpoints& checkpoints) {
  Renderer renderer(scene, settings, guide, film, pool, clock);
  if (checkpoints.resume_from) {
    if (!renderer.load_state(*checkpoints.resume_from))
      return Error{ErrorCode::kCorrupt, "not a state of this render", "checkpoint"};
  } else if (const auto pilot = render_pilot(scene, settings, guide, pool, clock, stop)) {
    renderer.begin_after(*pilot);
  }
  const Error canceled{ErrorCode::kCanceled, "canceled", ""};
  Checkpointer* keeper = checkpoints.keeper;
  const auto due = [&] { return keeper && keeper->due(); };
  const auto pause = [&] { return due() || renderer.out_of_time(); };
  const auto save = [&] {
    return keeper->save([&](SnapshotWriter& out) { renderer.save_state(out); });
  };
  while (renderer.in_pass() || renderer.start_pass()) {
    while (renderer.units_left() > 0 && !renderer.out_of_time()) {
      renderer.sample(renderer.units_left(), pause, stop, observer);
      if (stop.stop_requested()) return canceled;
      if (due() && !save()) return canceled;
    }
    if (!renderer.pass_whole()) break;
    renderer.end_pass();
    observer.on_pass(renderer.progress(), renderer.stats(), guide);
  }
  if (keeper) (void)save();  // so that more can be added to it some day
  return renderer.stats();
}

}  // namespace qray
