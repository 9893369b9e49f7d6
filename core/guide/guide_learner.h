// The part of a guide that learns from paths. Tiles record into deltas of their own, from any
// thread; update() is called from one thread at a time, end_pass() while no other call runs.
#pragma once

#include <memory>
#include <span>

#include "core/guide/guide_point.h"
#include "core/guide/guide_share.h"

namespace qray {

// One scattering event of a path, as a guide learns from it.
struct GuideVertex {
  GuidePoint at;
  Vec3 p;                 // metres
  Vec3 wi;                // the direction taken
  float pdf_w = 0;        // the density it was drawn with
  bool guidable = false;  // not a delta lobe
  // What the direction was paid: radiance, nee's share left out, the further path as the guide
  // expects it where it can, else as it went.
  Rgb arriving;

  // For methods that learn by reinforcement: a reward, and where the path went on. Filled if the
  // guide's needs() say so.
  struct Transition {
    // Luminance emitted toward here by what the ray reached, no MIS weight; or scattered toward
    // here of lights that no ray reaches.
    float emitted = 0;
    float albedo = 0;    // luminance of this surface's, seen from where the path came
    bool lands = false;  // the next vertex of the path is where the ray landed
  } transition;
  // For methods that learn how often to draw from the BSDF. Filled if the guide's needs() say so.
  struct BsdfPart {
    float pdf_w = 0;  // the BSDF's density for the direction taken
    float f_cos = 0;  // luminance of f |cos|
    // For methods that draw in place of a surface's base, where they expect anything: the base's
    // part of pdf_w, the guide's own density, and the luminance of what the surface scatters of
    // white light.
    float base_pdf_w = 0, guide_pdf_w = 0, albedo = 1;
    GuidedSurface surface{};
  } bsdf;
};

// Tables leave out what was paid more, in units of the brightest light. A picture leaves out
// nothing.
constexpr double kMaxPaid = 1024;

// What a method learns from beside what every vertex has.
struct GuideNeeds {
  bool transition = false, bsdf = false;
};

// What one tile of one pass learned; each guide has its own kind.
class GuideDelta {
 public:
  virtual ~GuideDelta() = default;
};

class GuideLearner {
 public:
  virtual ~GuideLearner() = default;

  virtual GuideNeeds needs() const = 0;
  virtual std::unique_ptr<GuideDelta> make_delta() const = 0;
  // `path`: in the order of its vertices.
  virtual void record(std::span<const GuideVertex> path, GuideDelta& delta) const = 0;
  // Deltas arrive in the order of their tiles, whatever thread made them. `delta` came from
  // make_delta(), and is empty again afterwards.
  virtual void update(GuideDelta& delta) = 0;
  virtual void end_pass() = 0;  // what was updated rules sampling from here on
  // The picture gains little by a larger table: from here on, where the method can, it learns
  // about the states that it has.
  virtual void stop_growing() {}
  // Null: what this method learns depends on the order in which it learns it, so that one process
  // samples all of a pass.
  virtual GuideShare* share() { return nullptr; }
};

}  // namespace qray
