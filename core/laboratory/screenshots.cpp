#include "core/laboratory/screenshots.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/image/metrics.h"
#include "core/job/recover_picture.h"
#include "core/job/run_job.h"
#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr int kProbes = 64;        // directions
constexpr float kTooNear = 0.02f;  // of the scene's diagonal
constexpr float kMostLost = 0.5f;  // of the probes, where the scene is closed
constexpr int kTriesPerCamera = 1000;
constexpr int kMostCandidates = 24;
constexpr float kJump = 0.2f;             // of the lesser distance
constexpr float kSteepest = 0.5f;         // of a view's direction, its height
constexpr uint64_t kTargetSeed = 0x7a26;  // away from the inputs'

class Numbers {
 public:
  explicit Numbers(uint64_t seed) : state_(mix64(seed)) {}
  float next() {
    state_ = mix64(state_ + 0x9e3779b97f4a7c15u);
    return to_unit_float(static_cast<uint32_t>(state_ >> 32));
  }

 private:
  uint64_t state_;
};

Vec3 on_sphere(float u, float v) {
  const float z = 1 - 2 * u, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * v;
  return {r * std::cos(phi), z, r * std::sin(phi)};
}

// Whether all directions have room, and enough of them see the scene.
bool has_room(const PreparedScene& scene, Vec3 p, float diagonal) {
  int lost = 0;
  for (int i = 0; i < kProbes; ++i) {
    const float v = 0.61803399f * static_cast<float>(i);
    Hit hit;
    const Ray ray{p, on_sphere((static_cast<float>(i) + 0.5f) / kProbes, v - std::floor(v))};
    if (!scene.accel->intersect(ray, hit))
      ++lost;
    else if (hit.t < kTooNear * diagonal)
      return false;
  }
  return static_cast<float>(lost) < kMostLost * kProbes;
}

// How often what the camera sees changes from one direction to the next: in its mesh, its normal or
// its distance. 0: a bare wall.
int changes_seen(const PreparedScene& scene, const Camera& camera) {
  constexpr int kSide = 16;
  const CameraRays rays(camera, kSide, kSide);
  std::array<Hit, kSide> above{};
  int changes = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      Hit hit;
      const Ray ray =
          rays.ray({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, {0.5f, 0.5f});
      if (scene.accel->intersect(ray, hit))
        hit.ng = normalize(hit.ng);
      else
        hit = Hit{};
      const auto differs = [&](const Hit& other) {
        return hit.mesh != other.mesh || dot(hit.ng - other.ng, hit.ng - other.ng) > 1e-4f ||
               std::abs(hit.t - other.t) > kJump * std::min(hit.t, other.t);
      };
      if (x > 0) changes += differs(above[static_cast<size_t>(x) - 1]);
      if (y > 0) changes += differs(above[static_cast<size_t>(x)]);
      above[static_cast<size_t>(x)] = hit;
    }
  return changes;
}

// As many pixels of it as a view has, of the same size as a whole picture's.
float cropped_fov_deg(float vertical_fov_deg, float picture_height) {
  const float half = std::tan(vertical_fov_deg * (kPi / 360)) * kScreenshotSide / picture_height;
  return std::atan(half) * (360 / kPi);
}

Status shoot(const PreparedScene& scene, const RenderSettings& settings, Guide* guide, Film& film,
             TaskPool& pool, std::stop_token stop, const Clock& clock) {
  RenderObserver silent;
  const Result<RenderStats> stats =
      render(scene, settings, guide, film, pool, silent, std::move(stop), clock);
  return stats ? Status{} : stats.error();
}

// Without what lights show of themselves.
Image reflected(const Film& film) {
  Image picture = film.develop();
  const Image seen = film.seen();
  for (size_t i = 0; i < seen.data().size(); ++i)
    picture.data()[i] = std::max(0.0f, picture.data()[i] - seen.data()[i]);
  return picture;
}

}  // namespace

std::vector<Camera> screenshot_cameras(const PreparedScene& scene, int count, int most_height,
                                       uint64_t seed) {
  Numbers numbers(seed);
  const Vec3 extent = scene.bounds.extent();
  const float diagonal = length(extent);
  std::vector<Camera> cameras;
  Camera best;
  int changes = 0, candidates = 0;
  for (int tries = count * kTriesPerCamera; tries > 0 && std::ssize(cameras) < count; --tries) {
    Camera camera = scene.scene.camera;
    camera.aperture_radius = 0;
    const float larger =
        static_cast<float>(std::max(most_height, kScreenshotSide)) / kScreenshotSide;
    camera.vertical_fov_deg = cropped_fov_deg(camera.vertical_fov_deg,
                                              kScreenshotSide * std::pow(larger, numbers.next()));
    for (int a = 0; a < 3; ++a)
      camera.position[a] = scene.bounds.lo[a] + extent[a] * numbers.next();
    Vec3 ahead = on_sphere(numbers.next(), numbers.next());
    ahead.y *= kSteepest;
    camera.target = camera.position + normalize(ahead) * diagonal;
    if (!has_room(scene, camera.position, diagonal)) continue;
    const int seen = changes_seen(scene, camera);
    if (seen == 0) continue;
    if (candidates == 0)
      candidates = 1 + static_cast<int>(numbers.next() * kMostCandidates), changes = 0;
    if (seen > changes) best = camera, changes = seen;
    if (--candidates == 0) cameras.push_back(best);
  }
  return cameras;
}

Result<std::vector<TrainingView>> take_screenshots(const PreparedScene& scene,
                                                   RenderSettings settings,
                                                   const std::optional<TableFile>& table,
                                                   const ScreenshotOptions& options, TaskPool& pool,
                                                   std::stop_token stop, const Clock& clock,
                                                   const std::function<void(int)>& on_view) {
  const std::vector<Camera> cameras =
      screenshot_cameras(scene, options.views, settings.height, options.seed);
  if (std::ssize(cameras) < options.views)
    return Error{ErrorCode::kInvalid,
                 "only " + std::to_string(cameras.size()) + " of " + std::to_string(options.views) +
                     " views were found: the scene has hardly a place to look from",
                 "scene"};
  settings.width = settings.height = kScreenshotSide;
  settings.seconds = 0;
  settings.learning_samples = 0;
  settings.passes.clear();
  settings.gate = false;  // the table rules where there is one
  Result<std::unique_ptr<Guide>> guide = load_guide(scene, settings, table);
  if (!guide) return guide.error();
  RenderSettings of_targets = settings;
  Result<std::unique_ptr<Guide>> own = std::unique_ptr<Guide>();
  Guide* target_guide = guide.value().get();
  if (options.guided_targets) {
    of_targets.method = "adaptive";
    of_targets.learning_samples = options.target_samples;
    own = load_guide(scene, of_targets, std::nullopt);
    if (!own) return own.error();
    target_guide = own.value().get();
  }
  std::vector<TrainingView> views;
  int samples = options.least_samples;
  for (const Camera& camera : cameras) {
    settings.camera = of_targets.camera = camera;
    of_targets.estimates_noise = false;
    of_targets.samples = std::max(1, options.target_samples / 2);
    of_targets.seed = mix64(options.seed + views.size()) + kTargetSeed;
    std::vector<Image> halves;
    for (int half = 0; half < 2; ++half, ++of_targets.seed) {
      Film film(settings.width, settings.height);
      if (Status s = shoot(scene, of_targets, target_guide, film, pool, stop, clock); !s)
        return s.error();
      halves.push_back(reflected(film));
    }
    Image target = halves[0];
    for (size_t i = 0; i < target.data().size(); ++i)
      target.data()[i] = 0.5f * (halves[0].data()[i] + halves[1].data()[i]);
    // The mean lies as far from each half as it does, on average, from the truth.
    const double target_relmse = relmse(halves[0], target);
    for (int i = 0; i < options.inputs; ++i) {
      settings.seed = mix64(options.seed + views.size());
      settings.samples = samples;
      samples = samples >= options.most_samples ? options.least_samples : 2 * samples;
      settings.estimates_noise = true;
      Film film(settings.width, settings.height);
      if (Status s = shoot(scene, settings, guide.value().get(), film, pool, stop, clock); !s)
        return s.error();
      Result<RecoveryInput> input = recovery_input(scene, settings, film, pool, stop);
      if (!input) return input.error();
      views.push_back({std::move(input).value(), target, target_relmse});
    }
    on_view(static_cast<int>(views.size()));
  }
  return views;
}

}  // namespace qray
