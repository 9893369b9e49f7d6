// "motion" of a JSON scene's meshes, instances, lights and cameras: docs/scene_format.md. Throws
// ImportFailure. Any thread.
#pragma once

#include <optional>

#include "core/import/json_tree.h"
#include "core/scene/light.h"
#include "core/scene/motion.h"

namespace qray {

class JsonMotion {
 public:
  // Of the node's "motion"; none: it has none.
  static std::optional<JsonMotion> read(const JsonNode& node);

  double end() const { return motion_.end(); }  // seconds: its last key
  // From where the node's `transform` puts things to where they are then.
  Transform at(double seconds) const;
  // Of a camera that stands so at rest.
  std::shared_ptr<const CameraPath> path_of(const Camera& rest) const;

 private:
  NodeMotion motion_;
  Vec3 center_;  // stays where it is while things turn and grow
};

void place_light(const Transform& to_world, PunctualLight& light);

}  // namespace qray
