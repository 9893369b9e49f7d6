// The picture that errors are measured against: two halves of equal passes and independent random
// numbers, so that its own error is known. Kept as an EXR file whose attributes hold the rest. One
// thread; the pool renders.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/laboratory/chart/results.h"
#include "core/render/render_loop.h"

namespace qray {

struct Reference {
  ChartReference about;
  Image picture;
};

// What the halves a and b of (a + b)/2 tell of its error.
struct HalvesError {
  double relmse = 0, relmse_trimmed = 0;
  double mean_standard_error = 0;  // of mean luminance, relative; pixels taken as independent
};
// Halves of one size; fails where they are not finite.
Result<HalvesError> halves_error(const Image& a, const Image& b);

// Where a reference of this scene (as the chart calls it), size, depth, camera and method lies in
// the folder `cache`.
std::filesystem::path reference_path(const std::filesystem::path& cache, std::string_view name,
                                     const PreparedScene& scene, const RenderSettings& settings);

// The one at `path` if it was asked to take `seconds` or more.
Result<std::optional<Reference>> find_reference(const std::filesystem::path& path, double seconds);

// Renders for settings.seconds in all and writes `path`. The seeds are no chart's. Both leave the
// scene's name to the caller.
Result<Reference> make_reference(const std::filesystem::path& path, const PreparedScene& scene,
                                 RenderSettings settings, TaskPool& pool, RenderObserver& observer,
                                 std::stop_token stop, const Clock& clock);

}  // namespace qray
