// One job from settings to picture and table: what the command and the server both do, so that
// their pictures are the same bits. Knows no paths, no HTTP.
#pragma once

#include "core/guide/table_file.h"
#include "core/image/image_io.h"
#include "core/job/picture_passes.h"
#include "core/job/recover_picture.h"
#include "core/render/render_loop.h"

namespace qray {

struct JobResult {
  RenderStats stats;
  std::optional<TableFile> table;  // what the guide knows now; none for method `none`
  ImageMetadata metadata;          // for the picture: seed, samples, method, table, scene hash ...
  std::optional<Image> recovered;  // linear; where a network was given
  ImageMetadata recovered_metadata;
  std::optional<LayeredPicture> passes;  // where the settings ask for some
};

// The settings' guide, null for the method none, with what `table` holds; its method must be the
// settings' (else kInvalid).
Result<std::unique_ptr<Guide>> load_guide(const PreparedScene& scene,
                                          const RenderSettings& settings,
                                          const std::optional<TableFile>& table);

// What a guide knows, as a file. `parent`: the table that it began with.
TableFile table_of(const GuideTable& guide, const SceneHash& scene,
                   const std::optional<TableHeader>& parent);

// What a job begins with: its guide, and the table that this was loaded from.
struct StartingGuide {
  std::unique_ptr<Guide> guide;      // null: method none
  std::optional<TableHeader> table;  // none: the guide knows nothing yet
};

// `table_in` must be of the settings' method (else kInvalid). It is moved into the guide.
// `recovery`: null, the picture stays as it was sampled. With `checkpoints.resume_from` the job
// goes on (render_loop.h), and `table_in` must be what it was begun with; its header is enough.
Result<JobResult> run_job(const PreparedScene& scene, RenderSettings settings,
                          std::optional<TableFile> table_in, Film& film, TaskPool& pool,
                          RenderObserver& observer, std::stop_token stop, const Clock& clock,
                          const Recovery* recovery = nullptr, const Checkpoints& checkpoints = {});

// The same, of a guide that is loaded already; with `checkpoints.resume_from`, of a fresh one.
// `sampler`: as of render().
Result<JobResult> run_guided_job(const PreparedScene& scene, RenderSettings settings,
                                 StartingGuide start, Film& film, TaskPool& pool,
                                 RenderObserver& observer, std::stop_token stop, const Clock& clock,
                                 const Recovery* recovery = nullptr,
                                 const Checkpoints& checkpoints = {},
                                 PassSampler* sampler = nullptr);

// Of a picture: what it was made with. `table_out`: null, none.
ImageMetadata picture_metadata(const RenderStats& stats, const PreparedScene& scene,
                               const std::optional<TableHeader>& table_in,
                               const TableHeader* table_out);

// Makes the film's picture whole, and says so in the result.
Status recover_result(const PreparedScene& scene, const RenderSettings& settings,
                      const Recovery& recovery, const Film& film, TaskPool& pool,
                      std::stop_token stop, const Clock& clock, JobResult& result);

// Makes the passes that the settings ask for, with the metadata of the result's picture.
Status add_passes(const PreparedScene& scene, const RenderSettings& settings, const Film& film,
                  const NeighbourFrames& neighbours, TaskPool& pool, std::stop_token stop,
                  const Clock& clock, JobResult& result);

// Fit of a table to a scene by exact hashes; kConflict names what differs.
Status table_fits(const TableHeader& header, const SceneHash& hash);

}  // namespace qray
