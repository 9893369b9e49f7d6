// What recovery knows of every pixel beside its light: of a ray through its centre, which follows
// mirrors and clear glass to what is seen in them, or the mean of four where its neighbours show
// something else. Any thread.
#pragma once

#include <array>
#include <limits>
#include <stop_token>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/render/prepared_scene.h"
#include "core/settings/render_settings.h"

namespace qray {

// Channels, in the order of core/recover/network.h: albedo, mirrors' tints included (3), and of
// what shines in a mirror at least its radiance up to 1, so that light over albedo is never more
// than was seen by much; shading normal towards the eye, world space (3); length of the path, in
// diagonals of the scene; kind of surface, [0, 2]. Where no surface is: albedo 0, or the mirrors'
// tint; normal 0, depth 2, kind 2.
constexpr int kFeatureChannels = 8;

struct Seen {
  std::array<float, kFeatureChannels> features{};
  float distance = std::numeric_limits<float>::infinity();  // metres, by way of the mirrors
  // Hit::mesh of what is seen and, above kMirrorShift, through how many mirrors.
  uint32_t surface = std::numeric_limits<uint32_t>::max();
  Rgb emitted{};  // toward here by what the ray meets first
};
constexpr int kMirrorShift = 27;
// `diagonal`: of the scene; `pixel`: what the ray stands for.
Seen see(const PreparedScene& scene, Ray ray, float diagonal, PixelCone pixel);

struct FeaturePictures {
  Image features;  // kFeatureChannels
  Image emitted;   // 3: Seen::emitted
};

// Of the settings' size and camera. kCanceled when stopped.
Result<FeaturePictures> render_features(const PreparedScene& scene, const RenderSettings& settings,
                                        TaskPool& pool, std::stop_token stop);

}  // namespace qray
