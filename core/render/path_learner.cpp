#include "core/render/path_learner.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

constexpr float kMostRatio = 64;  // of densities

}  // namespace

void PathLearner::begin(GuideDelta* delta, double* saved) {
  delta_ = delta;
  saved_ = saved;
  begin_ = vertices_.size();
}

void PathLearner::end() {
  if (has_vertex()) paths_.push_back({begin_, vertices_.size(), delta_, saved_});
}

void PathLearner::vertex(const GuidePoint& at, Vec3 p) {
  if (has_vertex()) notes_.back().lands = vertices_.back().transition.lands = true;
  GuideVertex& v = vertices_.emplace_back();
  v.at = at;
  v.p = p;
  notes_.emplace_back();
}

void PathLearner::emitted(Rgb radiance, float mis) {
  if (!has_vertex()) return;
  if (needs_.transition) vertices_.back().transition.emitted = luminance(radiance);
  notes_.back().emitted += notes_.back().between * radiance * mis;
}

void PathLearner::scattered(const ScatterSample& next, float inverse_chance, Rgb throughput,
                            float survival_chance) {
  if (!has_vertex()) return;
  notes_.back().to_pixel = throughput * next.weight;
  notes_.back().saves =
      next.bsdf_pdf_w > 0
          ? survival_chance * (std::min(next.pdf_w / next.bsdf_pdf_w, kMostRatio) - 1)
          : 0;
  GuideVertex& v = vertices_.back();
  v.wi = next.wi;
  v.pdf_w = next.pdf_w;
  if (needs_.bsdf) v.bsdf = {next.bsdf_pdf_w, luminance(next.weight) * next.pdf_w};
  v.guidable = true;
  notes_.back().weight = next.weight * inverse_chance;
  notes_.back().lobes_weight = next.lobes_weight * inverse_chance;
}

void PathLearner::scattered_delta(bool at_vertex, Rgb weight) {
  if (!has_vertex()) return;
  notes_.back().between *= weight;
  if (at_vertex) notes_.back().weight = notes_.back().lobes_weight = Rgb{1.0f};
}

void PathLearner::flush() {
  for (const Path& path : paths_) {
    for (size_t i = path.end; i-- > path.begin;) {
      const Note& x = notes_[i];
      vertices_[i].arriving = x.emitted;
      if (!x.lands) continue;
      const Note& y = notes_[i + 1];
      const Rgb& landed = vertices_[i + 1].arriving;
      const Rgb further = y.credible ? y.expected + y.lobes_weight * landed : y.weight * landed;
      vertices_[i].arriving += x.between * (y.direct + further);
      if (needs_.transition) vertices_[i].transition.emitted += luminance(x.between * y.as_emitted);
    }
    if (path.saved) *path.saved += saved_by(path);
    guide_->record(std::span(vertices_).subspan(path.begin, path.end - path.begin), *path.delta);
  }
  discard();
}

double PathLearner::saved_by(const Path& path) const {
  double saved = 0;
  for (size_t i = path.begin; i < path.end; ++i)
    saved += static_cast<double>(sqr(luminance(notes_[i].to_pixel * vertices_[i].arriving)) *
                                 notes_[i].saves);
  return std::isfinite(saved) ? saved : 0;
}

void PathLearner::discard() {
  vertices_.clear();
  notes_.clear();
  paths_.clear();
}

}  // namespace qray
