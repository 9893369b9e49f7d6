// One job from settings to picture and table: what the command and the server both do, so that
// their pictures are the same bits. Knows no paths, no HTTP.
#pragma once

#include "core/guide/table_file.h"
#include "core/image/image_io.h"
#include "core/render/render_loop.h"

namespace qray {

struct JobResult {
  RenderStats stats;
  std::optional<TableFile> table;  // what the guide knows now; none for method `none`
  ImageMetadata metadata;          // for the picture: seed, samples, method, table, scene hash ...
};

// The settings' guide, null for the method none, with what `table` holds; its method must be the
// settings' (else kInvalid).
Result<std::unique_ptr<Guide>> load_guide(const PreparedScene& scene,
                                          const RenderSettings& settings,
                                          const std::optional<TableFile>& table);

// `table_in` must be of the settings' method (else kInvalid). It is moved into the guide.
Result<JobResult> run_job(const PreparedScene& scene, const RenderSettings& settings,
                          std::optional<TableFile> table_in, Film& film, TaskPool& pool,
                          RenderObserver& observer, std::stop_token stop, const Clock& clock);

// Fit of a table to a scene by exact hashes; kConflict names what differs.
Status table_fits(const TableHeader& header, const SceneHash& hash);

}  // namespace qray
