#include "core/job/run_job.h"

namespace qray {
ImageMetadata picture_metadata(const RenderStats& stats, const PreparedScene& scene,
                               const std::optional<TableHeader>& table_in,
                               const TableHeader* table_out) {
  ImageMetadata m;
  m["program"] = QRAY_VERSION;
  m["scene"] = scene.scene.name;
  m["scene_hash"] = scene.hash.whole().hex();
  m["method"] = stats.method;
  m["unbiased"] = stats.unbiased ? "true" : "false";
  m["nee"] = stats.nee ? "true" : "false";
  m["seed"] = std::to_string(stats.seed);
  m["samples"] = std::to_string(stats.samples_per_pixel);
  std::string passes;
  for (int n : stats.passes) passes += (passes.empty() ? "" : ",") + std::to_string(n);
  m["passes"] = passes;
  if (stats.last_pass_tiles > 0) m["last_pass_tiles"] = std::to_string(stats.last_pass_tiles);
  if (stats.pilot_samples > 0) m["pilot_samples"] = std::to_string(stats.pilot_samples);
  m["pixels"] = stats.pixels;
  m["learning_samples"] = std::to_string(stats.learning_samples_per_pixel);
  m["table_in"] = table_in ? table_in->id : "none";
  m["table_out"] = table_out ? table_out->id : "none";
  return m;
}

Status recover_result(const PreparedScene& scene, const RenderSettings& settings,
                      const Recovery& recovery, const Film& film, TaskPool& pool,
                      std::stop_token stop, const Clock& clock, JobResult& result) {
  const double begin = clock.seconds();
  Result<Recovered> recovered =
      recover_picture(scene, settings, recovery, film, pool, std::move(stop));
  if (!recovered.ok()) return recovered.error();
  result.recovered = std::move(recovered.value().picture);
  result.stats.recovery = recovery.name;
  result.stats.recovery_held_pixels = recovered.value().held;
  result.stats.recovery_seconds = clock.seconds() - begin;
  return {};
}

Status add_passes(const PreparedScene& scene, const RenderSettings& settings, const Film& film,
                  const NeighbourFrames& neighbours, TaskPool& pool, std::stop_token stop,
                  const Clock& clock, JobResult& result) {
  if (!settings.makes_passes()) return {};
  const double begin = clock.seconds();
  Result<LayeredPicture> passes = make_picture_passes(scene, settings, film, result.recovered,
                                                      neighbours, pool, std::move(stop));
  if (!passes.ok()) return passes.error();
  result.passes = std::move(passes).value();
  result.passes->metadata.merge(
      ImageMetadata(result.recovered ? result.recovered_metadata : result.metadata));
  result.stats.picture_passes_seconds = clock.seconds() - begin;
  return {};
}

TableFile table_of(const GuideTable& guide, const SceneHash& scene,
                   const std::optional<TableHeader>& parent) {
  TableFile table;
  if (parent) table.header.parents.push_back(parent->id);
  table.header.method = table_method(guide.method());
  table.header.program = QRAY_VERSION;
  table.header.geometry = scene.geometry;
  table.header.materials = scene.materials;
  table.header.lights = scene.lights;
  table.header.samples_seen = guide.stats().samples_seen;
  table.sections = guide.save();
  table.header.id = table_id(table);
  return table;
}

Status table_fits(const TableHeader& header, const SceneHash& hash) {
  std::string differs;
  const auto compare = [&](const char* what, const Digest& a, const Digest& b) {
    if (!(a == b)) differs += (differs.empty() ? "" : ", ") + std::string(what);
  };
  compare("geometry", header.geometry, hash.geometry);
  compare("materials", header.materials, hash.materials);
  compare("lights", header.lights, hash.lights);
  if (differs.empty()) return {};
  return Error{ErrorCode::kConflict,
               "the table was learned from another scene, whose " + differs + " differ", "table"};
}

Result<std::unique_ptr<Guide>> load_guide(const PreparedScene& scene,
                                          const RenderSettings& settings,
                                          const std::optional<TableFile>& table) {
  Result<std::unique_ptr<Guide>> made = make_guide(settings.method, scene.guide_setup(settings));
  if (!made.ok() || !table) return made;
  Guide* guide = made.value().get();
  if (!guide || table->header.method != table_method(guide->method())) {
    return Error{
        ErrorCode::kInvalid,
        "a table of method '" + table->header.method + "' does not serve '" + settings.method + "'",
        "/table"};
  }
  if (Status loaded = guide->load(table->sections); !loaded.ok()) return loaded.error();
  if (!table_fits(table->header, scene.hash)) guide->doubt();
  return made;
}

Result<JobResult> run_job(const PreparedScene& scene, RenderSettings settings,
                          std::optional<TableFile> table_in, Film& film, TaskPool& pool,
                          RenderObserver& observer, std::stop_token stop, const Clock& clock,
                          const Recovery* recovery, const Checkpoints& checkpoints) {
  Result<std::unique_ptr<Guide>> made =
      checkpoints.resume_from ? make_guide(settings.method, scene.guide_setup(settings))
                              : load_guide(scene, settings, table_in);
  if (!made.ok()) return made.error();
  StartingGuide start{std::move(made).value(), {}};
  if (table_in) start.table = std::move(table_in->header);
  return run_guided_job(scene, std::move(settings), std::move(start), film, pool, observer,
                        std::move(stop), clock, recovery, checkpoints);
}

Result<JobResult> run_guided_job(const PreparedScene& scene, RenderSettings settings,
                                 StartingGuide start, Film& film, TaskPool& pool,
                                 RenderObserver& observer, std::stop_token stop, const Clock& clock,
                                 const Recovery* recovery, const Checkpoints& checkpoints,
                                 PassSampler* sampler) {
  Guide* guide = start.guide.get();
  if (recovery)
    if (Status s = check_recovery(*recovery, settings); !s) return s.error();
  settings.estimates_noise |= recovery != nullptr || passes_need_noise(settings);
  Result<RenderStats> stats =
      render(scene, settings, guide, film, pool, observer, stop, clock, checkpoints, sampler);
  if (!stats.ok()) return stats.error();
  JobResult result;
  result.stats = std::move(stats).value();
  if (recovery)
    if (Status s = recover_result(scene, settings, *recovery, film, pool, stop, clock, result);
        !s.ok())
      return s.error();
  if (guide) result.table = table_of(*guide, scene.hash, start.table);
  result.metadata = picture_metadata(result.stats, scene, start.table,
                                     result.table ? &result.table->header : nullptr);
  if (recovery) {
    result.recovered_metadata = result.metadata;
    result.recovered_metadata["recovery"] = recovery->name;
    result.recovered_metadata["unbiased"] = "false";
  }
  if (Status s = add_passes(scene, settings, film, {}, pool, std::move(stop), clock, result);
      !s.ok())
    return s.error();
  return result;
}

}  // namespace qray
