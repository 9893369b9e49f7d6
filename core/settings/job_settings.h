// From what was asked for to what is rendered. Pure.
#pragma once

#include "core/scene/scene.h"
#include "core/settings/job_fields.h"

namespace qray {

inline Vec3 vec3_of(const Vector3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
// The request's members of "camera"; nothing where it has none.
std::optional<CameraRequest> camera_request(const JobRequest& request);
// The camera with what the request says of it.
Camera camera_of(const CameraRequest& request, Camera camera);

// One of samples and seconds is given afterwards: without either, and without noise, 64 samples;
// with noise alone, `max_seconds` for all frames.
void complete_budget(JobRequest& request, double max_seconds);
// Gives what the request leaves to the table of fields: each default of a job, those of the guide
// that its method has.
void fill_defaults(JobRequest& request, const FieldTable& fields = job_fields());

// Puts what was given into the settings, but for the camera.
void apply(const JobRequest& request, RenderSettings& settings,
           const FieldTable& fields = job_fields());
// With what the request leaves to the scene: size, depth, members of the camera.
RenderSettings settings_of(const JobRequest& request, const Scene& scene,
                           const FieldTable& fields = job_fields());

}  // namespace qray
