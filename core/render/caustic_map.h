// From where mirrors and glass send light to a place, as photons showed (Jensen 1995, "Importance
// Driven Path Tracing using the Photon Map"). A path that scatters near where they arrived may aim
// at where they came from: a share of its directions is drawn from lobes about those, and every
// density counts that share, so that the mean of a picture stays what it is. The share is what the
// light is worth there, against all that arrives elsewhere, and small where it gains little.
// Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"
#include "core/render/caustic_photons.h"

namespace qray {

class CausticMap {
 public:
  explicit CausticMap(const CausticPhotons& photons);
  bool empty() const { return nodes_.empty(); }  // too few places gain: no place has a share
  size_t size_bytes() const { return nodes_.capacity() * sizeof(Node); }  // of memory

  // Where photons came from: about each of these places a lobe of about this radius, in metres.
  static constexpr size_t kLobes = 16;
  struct alignas(32) Lobes {
    std::array<float, kLobes> x, y, z, radius;
  };
  struct Place {
    const Lobes* lobes = nullptr;
    float share = 0;  // of directions that are to be drawn from the lobes; 0: none
  };
  Place find(Vec3 p) const;

  // Unit directions from p, by a density of which a lobe has A / (1 + (1 - cosine) / s)^2: the
  // whole sphere has some. u: uniform in [0, 1)^2.
  static Vec3 sample(const Lobes& lobes, Vec3 p, Vec2 u);
  static float pdf_w(const Lobes& lobes, Vec3 p, Vec3 wi);

 private:
  // Of an octree over the photons, with half the side of its parent's.
  struct Node {
    std::array<uint32_t, 8> child{};  // 0: too few photons to tell it apart
    float share = 0;
    bool gains = false;  // much
    Lobes lobes;
  };
  struct Builder;

  const Node* node_at(Vec3 p) const;  // null: outside the root

  Vec3 lo_;
  float side_ = 0;           // of the root
  std::vector<Node> nodes_;  // the root first
};

}  // namespace qray
