// Who samples the units of a job's passes, where it is not the renderer's own threads alone. It may
// have them sampled by other processes, by Renderer::save_pass() and add_units().
#pragma once

#include <functional>
#include <stop_token>

#include "core/base/result.h"
#include "core/render/render_observer.h"

namespace qray {

class Renderer;

class PassSampler {
 public:
  virtual ~PassSampler() = default;
  // As Renderer::sample(): brings the renderer's pass on, to its end or until enough(). The
  // observer is told of each unit. An error ends the render.
  virtual Status sample(Renderer& renderer, const std::function<bool()>& enough,
                        const std::stop_token& stop, RenderObserver& observer) = 0;
};

}  // namespace qray
