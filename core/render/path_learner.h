// What a path tells the guide: at every vertex that scatters, what the direction taken was paid.
// Light that waits for its shadow ray arrives later, so paths are kept until a whole batch of rays
// is answered, then handed over. One per PathTracer.
#pragma once

#include <vector>

#include "core/guide/guide_learner.h"
#include "core/render/guide_savings.h"
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
  void vertex(const GuidePoint& at, Vec3 p, float survival_chance, Rgb throughput);
  // Luminance of that vertex' surface, if the guide wants it.
  bool wants_albedo() const { return needs_.transition; }
  void albedo(float albedo) { vertices_.back().transition.albedo = albedo; }
  // How that surface scatters, if the guide wants it: `albedo` as for a guide that expects.
  bool wants_bsdf() const { return needs_.bsdf; }
  void surface(const GuidedSurface& surface, float albedo) {
    vertices_.back().bsdf.surface = surface, vertices_.back().bsdf.albedo = albedo;
  }
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
  // Roulette let the path go on, `at_vertex` as below; `unguided_chance`: as it would without a
  // guide.
  void survived(bool at_vertex, float chance, Rgb control, float unguided_chance);
  // It goes on, not by a mirror or clear glass; a black weight: it was absorbed.
  void scattered(const ScatterSample& next);
  // The same by a mirror or clear glass, `at_vertex` if a vertex of the path is there.
  void scattered_delta(bool at_vertex, Rgb weight);
  // Direct light that a vertex (as current() told it) scatters on. No direction hits a punctual
  // light: for those who learn from what is hit, the surface is what emits.
  void direct(uint32_t vertex, Rgb radiance, bool punctual, float unguided_weight);

  // All direct light so far is there: records the paths that ended, and sums what guiding saved
  // them. What current() told before means nothing from then on.
  void flush();
  void discard();  // forget them

 private:
  struct Note {
    Rgb between{1.0f};    // factor of the mirrors and glass between it and the next vertex
    Rgb direct;           // that it scatters on
    Rgb as_emitted;       // the share of `direct` that punctual lights have
    Rgb weight;           // of what arrives in the direction taken,
    Rgb lobes_weight;     // and what of that is not of the surface's base
    Rgb expected;         // from the base
    float survivors = 1;  // 1 / the chance to survive
    bool credible = false;
    bool lands = false;  // the next vertex of the path is where the ray landed
    GuideSavings savings;
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
  GuideDelta* delta_ = nullptr;  // of the path under way; null: it is not learned from
  double* saved_ = nullptr;
  size_t begin_ = 0;
  std::vector<GuideVertex> vertices_;
  std::vector<Note> notes_;  // parallel
  std::vector<Path> paths_;
};

}  // namespace qray
