// Clusters of a scene's lights, as learned importance tells them apart (light_importance.h). Who
// picks lights makes them (LightPick::clusters()): groups of clusters, of each of which one is
// picked. Values.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/ray.h"

namespace qray {

struct LightClusters {
  struct Group {
    std::vector<float> priors;  // chances that sum to 1; empty: they depend on the point
    uint32_t count = 0;         // of clusters
    bool operator==(const Group&) const = default;
  };
  static constexpr size_t kMostGroups = 16, kMost = 512;  // clusters in all

  Bounds3 bounds;  // of the scene, metres
  std::vector<Group> groups;
  uint64_t fingerprint = 0;  // of where the lights are that the groups stand for

  uint32_t count() const {
    uint32_t sum = 0;
    for (const Group& group : groups) sum += group.count;
    return sum;
  }
  bool operator==(const LightClusters& o) const {
    return bounds.lo == o.bounds.lo && bounds.hi == o.bounds.hi && groups == o.groups &&
           fingerprint == o.fingerprint;
  }
};

// A cluster that was picked for a point. A light's estimate, times `scale`, is what the cluster
// sends over what was expected of it: the chance of the picks so far, over the cluster's own prior
// or weight.
struct ClusterPick {
  uint32_t cluster;
  float scale;
};

}  // namespace qray
