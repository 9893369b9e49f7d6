// Samples units of another process's render. That one decides: it saves what each pass needs
// (Renderer::save_pass()) and adds what comes back (Renderer::add_units()). What comes back are
// sums and counts, so that it does not matter who sampled which units, in which order, or how
// often. One thread calls; the pool's work.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "core/base/task_pool.h"
#include "core/film/film.h"
#include "core/render/render_workers.h"
#include "core/render/sample_unit.h"

namespace qray {

// What a pass says of its render, for who samples it to see that it is the same one.
struct PassOf {
  std::string scene, method;  // scene: its hash
  uint64_t seed = 0;
  int width = 0, height = 0, pixels = 0, light_groups = 0;
  int bounce_layers = 0;
  static PassOf of(const PreparedScene& scene, const RenderSettings& settings) {
    return {scene.hash.whole().hex(),
            settings.method,
            settings.seed,
            settings.width,
            settings.height,
            static_cast<int>(settings.pixels),
            static_cast<int>(settings.light_groups),
            settings.bounce_layers()};
  }
  bool operator==(const PassOf&) const = default;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.scene, self.method, self.seed, self.width, self.height, self.pixels,
            self.light_groups, self.bounce_layers);
  }
};

class UnitRenderer {
 public:
  // All outlive this; the settings are the other render's. kInvalid: passes of its method cannot
  // be shared (GuideLearner::share()).
  static Result<std::unique_ptr<UnitRenderer>> make(const PreparedScene& scene,
                                                    const RenderSettings& settings, TaskPool& pool);

  // What paths read of the guide, as Renderer::save_guide() wrote it; before a pass that needs
  // another one than the last. False: it is not of this render.
  bool set_guide(SnapshotReader& in);
  // The pass that is sampled from now on. False as above.
  bool start_pass(SnapshotReader& in);

  // Of these units. The same ones have the same bytes, but for the first kTimesBytes, which are
  // measured times. None: stopped.
  std::optional<Bytes> sample(size_t first, size_t count, const std::stop_token& stop);
  static constexpr size_t kTimesBytes = 3 * sizeof(uint64_t);
  uint64_t paths() const { return workers_.counters().paths; }  // that were sampled

 private:
  UnitRenderer(const PreparedScene& scene, const RenderSettings& settings,
               std::unique_ptr<Guide> guide, TaskPool& pool);

  const RenderSettings& settings_;
  const PassOf of_;
  const std::unique_ptr<Guide> guide_;  // a copy (guide_share.h)
  TaskPool& pool_;
  const CameraRays camera_;
  const LightSplit split_;
  const Film tiles_;  // has no samples
  RenderWorkers workers_;
  PixelPlan pixels_;
  std::vector<float> deviations_;
  GuidedPixels guided_;
  std::vector<TileSamples> samples_;
};

}  // namespace qray
