// Renders a prepared scene from the first pass to the last: a Renderer stepped for a job, which is
// stopped, kept and watched. The same settings and table give the same bits for any number of
// threads.
#pragma once

#include <stop_token>

#include "core/base/clock.h"
#include "core/base/task_pool.h"
#include "core/film/film.h"
#include "core/render/checkpoint.h"
#include "core/render/pass_sampler.h"
#include "core/render/prepared_scene.h"
#include "core/render/render_observer.h"
#include "core/render/renderer.h"
#include "core/settings/render_settings.h"

namespace qray {

// `guide` may be null (method none). Stops within 100 ms of a request with kCanceled; the film then
// holds what was finished. kCorrupt: what it should go on from is of another render; film and guide
// are then of no more use. It may go on to more samples, or seconds, than it was begun with.
// `sampler`: null, the pool's threads sample all; else its errors too.
Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock,
                           const Checkpoints& checkpoints = {}, PassSampler* sampler = nullptr);

// Steps a renderer, pass by pass, until its plan is over. `keeper` may be null; `write` writes what
// it keeps. kCanceled, and `sampler`, as above.
using WriteState = std::function<void(SnapshotWriter&)>;
Status step_render(Renderer& renderer, const Guide* guide, RenderObserver& observer,
                   const std::stop_token& stop, Checkpointer* keeper, const WriteState& write,
                   PassSampler* sampler = nullptr);

}  // namespace qray
