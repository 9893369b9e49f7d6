// What a path tells the guide: at every vertex that scatters, what the direction taken was paid.
// Light that waits for its shadow ray arrives later, so paths are kept until a whole batch of rays
// is answered, then handed over. One per PathTracer.
#pragma once

#include <vector>

#include "core/guide/guide_learner.h"
#include "core/render/path_state.h"

namespace qray {

class PathLearner {
 public:
  static constexpr uint32_t kNoVertex = ~0u;

  // Null: nothing is learned.
  explicit PathLearner(const GuideLearner* guide)
      : guide_(guide), needs_(guide ? guide->needs() : GuideNeeds{}) {}

  // A path; null: nothing is learned from it. `saved`: PixelTarget.
  void begin(GuideDelta* delta, double* saved);
  void end();
  bool on() const { return delta_ != nullptr; }

  // The path's next vertex where a guide may learn. Mirrors and clear glass are passed over: what
  // is seen in them counts as seen directly.
  void vertex(const GuidePoint& at, Vec3 p);
  // Luminance of that vertex' surface, if the guide wants it.
  bool wants_albedo() const { return needs_.transition; }
  void albedo(float albedo) { vertices_.back().transition.albedo = albedo; }
  uint32_t current() const {
    return on() ? static_cast<uint32_t>(vertices_.size() - 1) : kNoVertex;
  }
  // Light emitted toward the last vertex; `mis`: its weight against nee.
  void emitted(Rgb radiance, float mis);
  // What the ray went through kept this share of what comes along it.
  void attenuated(Rgb share) {
    if (has_vertex()) notes_.back().between *= share;
  }
  // What the guide expects the current vertex' base to scatter on, of radiance that arrives.
  void expected(Rgb scattered) {
    notes_.back().expected = scattered, notes_.back().credible = true;
  }
  // The path goes on, not by a mirror or clear glass; a black weight: it was absorbed. Of the path
  // before it, roulette included: its throughput, and the chance that it got so far.
  void scattered(const ScatterSample& next, float inverse_chance, Rgb throughput,
                 float survival_chance);
  // The same by a mirror or clear glass, `at_vertex` if a vertex of the path is there.
  void scattered_delta(bool at_vertex, Rgb weight);
  // Direct light that a vertex (as current() told it) scatters on. No direction hits a punctual
  // light: for those who learn from what is hit, the surface is what emits.
  void direct(uint32_t vertex, Rgb radiance, bool punctual) {
    notes_[vertex].direct += radiance;
    if (punctual) notes_[vertex].as_emitted += radiance;
  }

  // All direct light is there: records the paths, and sums what guiding saved them.
  //
  // Where a vertex' direction, drawn with density p, brought the pixel c, the BSDF's own density
  // p_bsdf would have brought c p / p_bsdf. Its second moment is the mean of c^2 p / p_bsdf over
  // directions drawn with p, so guiding there saves the mean of c^2 (p / p_bsdf - 1): both come
  // from the same paths, and where p finds light that p_bsdf would miss for long, both are known at
  // once. c leaves out roulette, and that the BSDF would have reached the vertex by other weights.
  void flush();
  void discard();  // forget them

 private:
  struct Note {
    Rgb emitted;        // toward the vertex, weighted, in its direction
    Rgb between{1.0f};  // factor of the mirrors and glass between it and the next vertex
    Rgb direct;         // that it scatters on
    Rgb as_emitted;     // the share of `direct` that punctual lights have
    Rgb weight;         // of what arrives in the direction taken,
    Rgb lobes_weight;   // and what of that is not of the surface's base
    Rgb expected;       // from the base
    Rgb to_pixel;       // what the pixel gets of what arrives in the direction taken
    float saves = 0;    // the factor of its square
    bool credible = false;
    bool lands = false;  // the next vertex of the path is where the ray landed
  };
  struct Path {
    size_t begin, end;
    GuideDelta* delta;
    double* saved;
  };
  double saved_by(const Path& path) const;
  bool has_vertex() const { return on() && vertices_.size() > begin_; }

  const GuideLearner* guide_;
  const GuideNeeds needs_;
  GuideDelta* delta_ = nullptr;
  double* saved_ = nullptr;
  size_t begin_ = 0;
  std::vector<GuideVertex> vertices_;
  std::vector<Note> notes_;  // parallel
  std::vector<Path> paths_;
};

}  // namespace qray
