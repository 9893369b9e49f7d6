#include "core/job/load_and_prepare.h"

#include "core/base/clock.h"

namespace qray {

Result<std::shared_ptr<const PreparedScene>> load_and_prepare_scene(
    const std::filesystem::path& path, int build_threads, const LoadOptions& options) {
  const SteadyClock clock;
  const double start = clock.seconds();
  Result<LoadedScene> loaded = load_scene(path, options);
  if (!loaded.ok()) return loaded.error();
  LoadedScene& read = loaded.value();
  BuildWatch watch;
  if (options.watch)
    watch = [&](double fraction) { return options.watch(LoadStep::kBuilding, fraction); };
  Result<std::shared_ptr<PreparedScene>> prepared =
      prepare_scene(std::move(read.scene), read.hash, build_threads, watch);
  if (!prepared.ok()) return prepared.error();
  PreparedScene& scene = *prepared.value();
  scene.warnings = std::move(read.warnings);
  if (read.dropped_triangles > 0) {
    scene.warnings.push_back(std::to_string(read.dropped_triangles) +
                             " triangles without area were left out");
  }
  scene.seconds = clock.seconds() - start;
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

}  // namespace qray
