#include "core/settings/job_settings.h"

#include "core/settings/frames.h"

namespace qray {
namespace {

constexpr int kUsualSamples = 64;  // where no budget was given

}  // namespace

std::optional<CameraRequest> camera_request(const JobRequest& request) {
  CameraRequest camera;
  const auto put = [&](const char* path, auto& member) {
    if (const FieldValue* value = request.find(path))
      member = std::get<typename std::remove_cvref_t<decltype(member)>::value_type>(*value);
  };
  put("camera/position", camera.position);
  put("camera/target", camera.target);
  put("camera/up", camera.up);
  put("camera/vertical_fov_deg", camera.vertical_fov_deg);
  put("camera/aperture_radius", camera.aperture_radius);
  put("camera/focus_distance", camera.focus_distance);
  put("camera/projection", camera.projection);
  put("camera/height", camera.height);
  return camera == CameraRequest() ? std::nullopt : std::optional(camera);
}

Camera camera_of(const CameraRequest& request, Camera camera) {
  if (request.position) camera.position = vec3_of(*request.position);
  if (request.target) camera.target = vec3_of(*request.target);
  if (request.up) camera.up = vec3_of(*request.up);
  const auto put = [](const std::optional<double>& from, float& to) {
    if (from) to = static_cast<float>(*from);
  };
  put(request.vertical_fov_deg, camera.vertical_fov_deg);
  put(request.aperture_radius, camera.aperture_radius);
  put(request.focus_distance, camera.focus_distance);
  put(request.height, camera.height);
  if (request.projection)
    camera.projection = projection_named(*request.projection).value_or(camera.projection);
  return camera;
}

void complete_budget(JobRequest& request, double max_seconds) {
  if (request.given(field::kSamples) || request.given(field::kSeconds)) return;
  if (request.given(field::kNoise))
    request.set(field::kSeconds, max_seconds / frame_count(request).value_or(1));
  else
    request.set(field::kSamples, kUsualSamples);
}

void fill_defaults(JobRequest& request, const FieldTable& fields) {
  const std::string method = request.get(field::kMethod);
  for (const Field& field : fields)
    if (field.fallback && (field.callers & kJob) != 0 && field.of_method(method) &&
        !request.find(field.path))
      request.set(field.path, *field.fallback);
}

void apply(const JobRequest& request, RenderSettings& settings, const FieldTable& fields) {
  for (const Field& field : fields)
    if (const FieldValue* value = request.find(field.path); value && field.setting.apply)
      field.setting.apply(settings, *value);
}

RenderSettings settings_of(const JobRequest& request, const Scene& scene,
                           const FieldTable& fields) {
  RenderSettings settings;
  settings.width = scene.width;
  settings.height = scene.height;
  settings.max_depth = scene.max_depth;
  settings.samples = 0;  // as many as fit, where only seconds are given
  apply(request, settings, fields);
  if (const std::optional<CameraRequest> camera = camera_request(request))
    settings.camera = camera_of(*camera, scene.camera);
  return settings;
}

}  // namespace qray
