// A tree over lights that picks one by about what it sends to a point (Conty Estevez and Kulla
// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"): nodes bound where their
// lights are and which way they shine. Eight children a node, weighed side by side: flatter trees
// compare smaller clusters, and vectors of the processor weigh eight in the time of two. A light
// that could send something always has a chance. Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/guide/light_clusters.h"
#include "core/math/ray.h"
#include "core/math/wide.h"

namespace qray {

// Shines within the angle `emission` of directions that lie within the angle `spread` of the axis,
// by the cosine of the angle to those; two-sided: of the opposite axis as well.
struct LightBounds {
  Bounds3 box;
  Vec3 axis{0, 0, 1};    // unit
  float intensity = 0;   // the most that it sends into any direction, W/sr, as luminance
  float cos_spread = 1;  // -1: every direction
  float cos_emission = 0;
  bool two_sided = false;
};

// Does it matter which of them is picked: do they stand farther apart than `apart` metres, or shine
// into different directions?
bool differ(std::span<const LightBounds> lights, float apart);

// Where light arrives. n: the unit normal of a surface that scatters only on that side; zero: light
// from all directions counts.
struct LightReceiver {
  Vec3 p, n;
};

class LightTree {
 public:
  explicit LightTree(std::span<const LightBounds> lights);  // not empty

  struct Pick {
    uint32_t light = 0;
    float probability = 0;  // 0: no light sends anything there
  };
  Pick sample(const LightReceiver& at, double u) const {
    Search search{.at = at, .u = u};
    run({&search, 1}, 1);
    return search.pick;
  }
  float probability(const LightReceiver& at, uint32_t light) const {  // that sample() picks it
    return probability(at, light, nullptr);
  }

  // The clusters on its two uppermost levels: the root's children, then those of each of these in
  // turn that is no light. `factors`: of each cluster's weight, over 0.
  std::vector<uint32_t> clusters() const;  // how many each group has
  // A search for a light.
  struct Search {
    LightReceiver at;
    double u = 0;                    // [0, 1]
    const float* factors = nullptr;  // null: all are 1, and nothing is `passed`
    Pick pick{0, 1};
    // The clusters that were picked until the light was, or until none was left that sends
    // anything; their scale is chance over weight.
    std::array<ClusterPick, 2> passed{};
    uint32_t passed_count = 0;
    uint32_t node = 0;  // where it is
  };
  // Of several, those whose bits are set, in turns of one node: none waits for another's numbers.
  void run(std::span<Search> searches, uint32_t lanes) const;
  float probability(const LightReceiver& at, uint32_t light, const float* factors) const;
  uint64_t fingerprint() const;  // of those clusters
  size_t size_bytes() const;

 private:
  static constexpr size_t kLanes = kWidth;
  static constexpr uint32_t kLight = 1u << 31;  // of Node::child: a light, else a node
  static constexpr uint32_t kNoChild = 0;       // the root is nobody's
  using Lanes = std::array<float, kLanes>;

  struct alignas(32) Node {
    Lanes x{}, y{}, z{}, radius{}, over_radius2{};  // a sphere about each child's box
    Lanes axis_x{}, axis_y{}, axis_z{}, cos_spread{}, sin_spread{}, cos_emission{};
    Lanes two_sided{};  // 1, or 0
    Lanes intensity{};  // 0: no child
    std::array<uint32_t, kLanes> child{};
    uint32_t parent = 0;  // its slot: kLanes times the node, plus the lane
  };
  struct Weights {
    alignas(32) Lanes of;
    float sum;
  };
  struct LaneAt {
    size_t lane;
    double u;
  };
  struct Builder;
  static Weights weigh(const Node& node, const LightReceiver& at);
  static void scale(Weights& weights, const float* factors);
  static LaneAt lane_at(const Weights& weights, double u);
  bool go_down(Search& search) const;  // by a node; false: it is at its end
  static constexpr uint32_t kNoGroup = ~0u;
  // The first cluster of a node's children; kNoGroup below the two levels.
  uint32_t first_cluster(uint32_t node) const {
    return node == 0                      ? 0
           : nodes_[node].parent < kLanes ? first_below_[nodes_[node].parent]
                                          : kNoGroup;
  }

  std::vector<Node> nodes_;                     // the root first
  std::vector<uint32_t> slot_of_light_;         // where it hangs
  std::array<uint32_t, kLanes> first_below_{};  // by the root's lanes: the first cluster in each
};

}  // namespace qray
