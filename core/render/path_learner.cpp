#include "core/render/path_learner.h"

#include <cmath>

namespace qray {
void PathLearner::begin(GuideDelta* delta, double* saved) {
  delta_ = delta;
  saved_ = saved;
  begin_ = vertices_.size();
}

void PathLearner::end() {
  if (has_vertex()) paths_.push_back({begin_, vertices_.size(), delta_, saved_});
  begin_ = vertices_.size();
  delta_ = nullptr;
}

void PathLearner::vertex(const GuidePoint& at, Vec3 p, float survival_chance, Rgb throughput) {
  if (has_vertex()) notes_.back().lands = vertices_.back().transition.lands = true;
  // Copies of empty ones: g++ clears this much memory in a slower way.
  static const GuideVertex empty_vertex;
  static const Note empty_note;
  GuideVertex& v = vertices_.emplace_back(empty_vertex);
  v.at = at;
  v.p = p;
  GuideSavings& savings = notes_.emplace_back(empty_note).savings;
  savings.reached = survival_chance;
  savings.throughput = throughput;
}

void PathLearner::emitted(Rgb radiance, float mis) {
  if (!has_vertex()) return;
  if (needs_.transition) vertices_.back().transition.emitted = luminance(radiance);
  Note& note = notes_.back();
  const Rgb emitted = note.between * radiance;
  note.savings.emitted += emitted * mis;
  note.savings.unguided_emitted += emitted * note.savings.unguided_weight(mis);
}

void PathLearner::direct(uint32_t vertex, Rgb radiance, bool punctual, float unguided_weight) {
  Note& note = notes_[vertex];
  note.direct += radiance;
  if (punctual) note.as_emitted += radiance;
  const float to_pixel = luminance(note.savings.throughput * radiance);
  note.savings.nee += to_pixel;
  note.savings.unguided_nee += to_pixel * unguided_weight;
}

void PathLearner::survived(bool at_vertex, float chance, Rgb control, float unguided_chance) {
  if (!has_vertex()) return;
  Note& note = notes_.back();
  if (!at_vertex) {
    note.between *= 1 / chance;
    return;
  }
  note.survivors = 1 / chance;
  note.savings.chance = chance;
  note.savings.unguided_chance = unguided_chance;
  note.savings.control = luminance(note.savings.throughput * control) * note.survivors;
}

void PathLearner::scattered(const ScatterSample& next) {
  if (!has_vertex()) return;
  Note& note = notes_.back();
  note.savings.to_pixel = note.savings.throughput * next.weight * note.survivors;
  if (next.unguided_pdf_w > 0) note.savings.density_ratio = next.pdf_w / next.unguided_pdf_w;
  GuideVertex& v = vertices_.back();
  v.wi = next.wi;
  v.pdf_w = next.pdf_w;
  v.bsdf.pdf_w = next.bsdf_pdf_w;
  v.bsdf.f_cos = luminance(next.weight) * next.pdf_w;
  v.bsdf.base_pdf_w = next.base_pdf_w;
  v.bsdf.guide_pdf_w = next.guide_pdf_w;
  v.guidable = true;
  note.weight = next.weight * note.survivors;
  note.lobes_weight = next.lobes_weight * note.survivors;
}

void PathLearner::scattered_delta(bool at_vertex, Rgb weight) {
  if (!has_vertex()) return;
  Note& note = notes_.back();
  note.between *= weight;
  if (!at_vertex) return;
  note.between *= note.survivors;
  note.weight = note.lobes_weight = Rgb{1.0f};
}

void PathLearner::flush() {
  for (const Path& path : paths_) {
    for (size_t i = path.end; i-- > path.begin;) {
      const Note& x = notes_[i];
      vertices_[i].arriving = x.savings.emitted;
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
  paths_.clear();
  const auto ended = static_cast<std::ptrdiff_t>(begin_);
  vertices_.erase(vertices_.begin(), vertices_.begin() + ended);
  notes_.erase(notes_.begin(), notes_.begin() + ended);
  begin_ = 0;
}

double PathLearner::saved_by(const Path& path) const {
  float saved = 0;
  for (size_t i = path.begin; i < path.end; ++i)
    saved += notes_[i].savings.saved(vertices_[i].arriving - notes_[i].savings.emitted);
  return std::isfinite(saved) ? static_cast<double>(saved) : 0;
}

void PathLearner::discard() {
  delta_ = nullptr;
  begin_ = 0;
  vertices_.clear();
  notes_.clear();
  paths_.clear();
}

}  // namespace qray
