#include "core/render/unit_renderer.h"

namespace qray {

Result<std::unique_ptr<UnitRenderer>> UnitRenderer::make(const PreparedScene& scene,
                                                         const RenderSettings& settings,
                                                         TaskPool& pool) {
  Result<std::unique_ptr<Guide>> guide = make_guide(settings.method, scene.guide_setup(settings));
  if (!guide.ok()) return guide.error();
  if (guide.value() && !guide.value()->share())
    return Error{ErrorCode::kInvalid,
                 "what '" + settings.method +
                     "' learns depends on its order, so that one process "
                     "renders all of it",
                 "/method"};
  return std::unique_ptr<UnitRenderer>(
      new UnitRenderer(scene, settings, std::move(guide).value(), pool));
}

UnitRenderer::UnitRenderer(const PreparedScene& scene, const RenderSettings& settings,
                           std::unique_ptr<Guide> guide, TaskPool& pool)
    : settings_(settings),
      of_(PassOf::of(scene, settings)),
      guide_(std::move(guide)),
      pool_(pool),
      camera_(settings.camera.value_or(scene.scene.camera), settings.width, settings.height),
      split_(light_split(scene.scene, settings).value()),
      tiles_(settings.width, settings.height, split_.layers),
      workers_(scene, settings, guide_.get(), pool, split_.layers.count() > 0 ? &split_ : nullptr),
      pixels_(settings) {}

bool UnitRenderer::set_guide(SnapshotReader& in) {
  if (!guide_) return false;
  guide_->share()->load_copy(in);
  return in.whole();
}

bool UnitRenderer::start_pass(SnapshotReader& in) {
  PassOf render;
  in(render, pixels_, deviations_, guided_);
  const size_t pixels = pixels_.pixels();
  return in.whole() && render == of_ && (deviations_.empty() || deviations_.size() == pixels) &&
         pixels_.fits() && (guide_ || (!guided_.guided && !guided_.learning));
}

std::optional<Bytes> UnitRenderer::sample(size_t first, size_t count, const std::stop_token& stop) {
  if (first > static_cast<size_t>(tiles_.tile_count()) ||
      count > static_cast<size_t>(tiles_.tile_count()) - first)
    return {};
  const PassView pass{camera_, settings_.seed, pixels_, deviations_, guided_};
  const bool learns = guide_ && guided_.learning;
  std::vector<std::unique_ptr<GuideDelta>> learned(count);
  if (samples_.size() < count) samples_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    samples_[i].start(tiles_.tile(static_cast<int>(first + i)), split_.layers.count());
    if (learns) learned[i] = guide_->make_delta();
  }
  const PathCounters before = workers_.counters();
  pool_.run(count, [&](size_t i, int worker) {
    PathTracer& tracer = workers_[worker].tracer;
    if (!sample_unit(pass, /*round=*/0, tracer, samples_[i], learned[i].get(), stop))
      tracer.discard();
  });
  Bytes of_guide;
  if (learns) {
    for (const std::unique_ptr<GuideDelta>& delta : learned) guide_->update(*delta);
    of_guide = guide_->share()->take_learned();
    of_guide.shrink_to_fit();
  }
  if (stop.stop_requested()) return {};

  Bytes bytes;
  SnapshotWriter out(
      [&](std::span<const uint8_t> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  PathCounters counters = workers_.counters();
  counters -= before;
  ByteWriter times;
  for (uint64_t* cycles : {&counters.timed_total, &counters.timed_tracing, &counters.timed_guiding})
    times.u64(std::exchange(*cycles, 0));
  bytes = times.take();
  out(uint64_t{first}, uint64_t{count}, counters, of_guide);
  for (size_t i = 0; i < count; ++i) samples_[i].save(out);
  return bytes;
}

}  // namespace qray
