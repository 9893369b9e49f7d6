// Photons that show where mirrors and glass send light: from the lights, by surfaces that scatter
// narrowly, to the first that does not. They steer paths (caustic_map.h) and are never seen. The
// same scene has the same photons for any number of threads.
#pragma once

#include <vector>

#include "core/base/task_pool.h"
#include "core/render/prepared_scene.h"

namespace qray {

// Whether a photon ends at a surface, and paths aim from there: some light scatters into all
// directions alike, or lobes are wide. base_chance: of the surface's parts.
inline bool catches_photons(const BsdfPoint& at, float base_chance) {
  constexpr float kWide = 0.5f;  // a roughness
  return base_chance > 0 || at.sp.roughness > kWide;
}

struct CausticPhoton {
  Vec3 p;     // where it arrived, metres
  Vec3 from;  // the last mirror or glass that it came by
};

// What sends a photon: the numbers of LightPick::emit().
struct PhotonStart {
  float u_light, u_side;
  Vec2 u_point, u_direction;
};

struct CausticPhotons {
  std::vector<CausticPhoton> photons;
  double share = 0;                 // of all photons that lights send, about
  std::vector<PhotonStart> starts;  // that had such a fate, of photons sent anywhere
  // Where some of the photons sent anywhere arrived, by mirrors or straight, and the share of all
  // that each stands for.
  std::vector<Vec3> arrivals;
  double arrival_share = 0;
};

// Photons sent anywhere; none where hardly any light goes by mirrors or glass. The pool's threads
// trace them.
CausticPhotons send_photons(const PreparedScene& scene, TaskPool& pool);
// Adds many more, sent nearly as those were that went by mirrors or glass.
void send_nearby(CausticPhotons& photons, const PreparedScene& scene, TaskPool& pool);

}  // namespace qray
