#include "core/live/walls.h"

#include <algorithm>

namespace qray {
namespace {

constexpr float kDistanceKept = 0.01f;  // of the scene's radius
constexpr float kSteepest = 0.1f;       // of the cosine: along a wall one may come nearer to it

struct Way {
  Vec3 end;
  Vec3 left{0, 0, 0};  // of the way, along the surface that ended it
};

Way walk(const PreparedScene& scene, Vec3 from, Vec3 way) {
  const float distance = length(way);
  if (!(distance > 0)) return {from};
  const Vec3 direction = way / distance;
  const float kept = kDistanceKept * scene.bounds.radius();
  Hit hit;
  if (!scene.accel->intersect({from, direction, distance + kept / kSteepest}, hit))
    return {from + way};
  const Vec3 normal = normalize(hit.ng);
  const float cosine = std::max(std::abs(dot(direction, normal)), kSteepest);
  const float walked = std::clamp(hit.t - kept / cosine, 0.0f, distance);
  const Vec3 left = direction * (distance - walked);
  return {from + direction * walked, left - normal * dot(left, normal)};
}

}  // namespace

Vec3 stop_before_walls(const PreparedScene& scene, Vec3 from, Vec3 to) {
  const Way first = walk(scene, from, to - from);
  return walk(scene, first.end, first.left).end;
}

}  // namespace qray
