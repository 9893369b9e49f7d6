// Whole jobs in one call, for tests that look at pictures. One thread calls; two render.
#pragma once

#include <optional>
#include <string>

#include "core/image/image.h"
#include "core/image/metrics.h"
#include "core/job/load_and_prepare.h"
#include "core/job/run_job.h"

namespace qray::test {

struct Rendered {
  Image image;
  JobResult job;
};

// Settings of a small picture.
RenderSettings small_settings(const std::string& method, int side_px, int samples,
                              uint64_t seed = 1);

// Of a job bounded by samples, the passes in which it may learn, without those after them: its
// table is the same.
RenderSettings learning_passes_of(RenderSettings settings);

// A job that must succeed: the calling test fails (and the picture is black) where it does not.
Rendered render(const PreparedScene& scene, const RenderSettings& settings,
                std::optional<TableFile> table = {});
// The same, and its error if it has one.
Result<Rendered> try_render(const PreparedScene& scene, const RenderSettings& settings,
                            std::optional<TableFile> table = {});

// scenes/<name>/scene.json, which must load.
std::shared_ptr<const PreparedScene> included_scene(const std::string& name);

bool same_bits(const Image& a, const Image& b);
double mean_luminance(const Image& image);
// Means over regions x regions blocks, row by row. The sides are multiples of `regions`.
std::vector<double> region_luminances(const Image& image, int regions);
double median(std::vector<double> values);

}  // namespace qray::test
