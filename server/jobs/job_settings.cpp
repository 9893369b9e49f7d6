#include "server/jobs/job_settings.h"

#include <charconv>

namespace qray::server {
namespace {

Vec3 vec3_of(const std::array<double, 3>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// As text of the fewest digits that read back as the same float: 0.2, not 0.20000000298.
double short_double(float v) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, v);
  double out = 0;
  std::from_chars(text, end, out);
  return out;
}

}  // namespace

Camera camera_of(const proto::CameraRequest& request, Camera camera) {
  if (request.position) camera.position = vec3_of(*request.position);
  if (request.target) camera.target = vec3_of(*request.target);
  if (request.up) camera.up = vec3_of(*request.up);
  const auto put = [](const std::optional<double>& from, float& to) {
    if (from) to = static_cast<float>(*from);
  };
  put(request.vertical_fov_deg, camera.vertical_fov_deg);
  put(request.aperture_radius, camera.aperture_radius);
  put(request.focus_distance, camera.focus_distance);
  return camera;
}

void fill_defaults(proto::JobRequest& request) {
  const RenderSettings defaults;
  const auto fill = [](auto& member, auto value) {
    if (!member) member = value;
  };
  fill(request.learning_samples, defaults.learning_samples);
  fill(request.alpha, short_double(defaults.huang.alpha));
  fill(request.gamma, short_double(defaults.huang.gamma));
  fill(request.grid, defaults.huang.grid);
}

RenderSettings settings_of(const proto::JobRequest& request, const Scene& scene) {
  RenderSettings settings;
  settings.method = request.method;
  settings.nee = request.nee;
  settings.pixels = pixels_named(request.pixels).value_or(Pixels::kAll);
  settings.width = request.width.value_or(scene.width);
  settings.height = request.height.value_or(scene.height);
  settings.samples = request.samples.value_or(0);
  settings.seconds = request.seconds.value_or(0);
  settings.noise = request.noise.value_or(0);
  settings.seed = request.seed;
  settings.max_depth = request.max_depth.value_or(scene.max_depth);
  settings.learning_samples = request.learning_samples.value_or(settings.learning_samples);
  if (request.alpha) settings.huang.alpha = static_cast<float>(*request.alpha);
  if (request.gamma) settings.huang.gamma = static_cast<float>(*request.gamma);
  settings.huang.grid = request.grid.value_or(settings.huang.grid);
  if (request.camera) settings.camera = camera_of(*request.camera, scene.camera);
  return settings;
}

}  // namespace qray::server
