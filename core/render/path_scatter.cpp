#include "core/base/cycle_clock.h"
#include "core/render/path.h"

namespace qray {

// Draws from the lobes at caustics or from the rest, by the place's share.
bool PathTracer::scatter(const PathVertex& v, float u_lobe, Vec2 u_direction, ScatterSample& next) {
  const float share = v.caustics.share;
  if (share == 0) return scatter_by_bsdf_or_guide(v, u_lobe, u_direction, next);
  if (u_lobe < share) {
    scatter_to_caustics(v, u_direction, next);
    return true;
  }
  if (!scatter_by_bsdf_or_guide(v, (u_lobe - share) / (1 - share), u_direction, next)) return false;
  float rescaled = 1 / (1 - share);
  if (!next.delta) {
    const float of_lobes = CausticMap::pdf_w(*v.caustics.lobes, v.surface.p, next.wi);
    const float pdf_w = lerp(share, next.pdf_w, of_lobes);
    rescaled = next.pdf_w / pdf_w;
    next.pdf_w = pdf_w;
    next.unguided_pdf_w = lerp(share, next.bsdf_pdf_w, of_lobes);
  }
  next.weight *= rescaled;
  next.lobes_weight *= rescaled;
  return true;
}

void PathTracer::scatter_to_caustics(const PathVertex& v, Vec2 u_direction, ScatterSample& next) {
  const Vec3 wi = CausticMap::sample(*v.caustics.lobes, v.surface.p, u_direction);
  const Vec3 wi_local = v.frame.to_local(wi);
  const BsdfEval eval = v.eval(wi_local);
  const float of_lobes = CausticMap::pdf_w(*v.caustics.lobes, v.surface.p, wi);
  if (v.mixture.guide > 0 || v.learns_bsdf) {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    next.guide_pdf_w = guide_->pdf_w(v.at, wi);
  }
  const float rest =
      v.mixture.pdf_w(next.guide_pdf_w, eval.base_pdf_w, eval.pdf_w - eval.base_pdf_w);
  next.wi = wi;
  next.pdf_w = lerp(v.caustics.share, rest, of_lobes);
  next.bsdf_pdf_w = eval.pdf_w;
  next.unguided_pdf_w = lerp(v.caustics.share, eval.pdf_w, of_lobes);
  next.base_pdf_w = eval.base_pdf_w;
  if (!eval.f_cos.is_black() && v.sides_agree(wi, wi_local)) {
    next.weight = eval.f_cos / next.pdf_w;
    next.lobes_weight = (eval.f_cos - eval.base_f_cos) / next.pdf_w;
  }
}

// Draws from the mixture of guide and BSDF.
bool PathTracer::scatter_by_bsdf_or_guide(const PathVertex& v, float u_lobe, Vec2 u_direction,
                                          ScatterSample& next) {
  const GuideMixture& mixture = v.mixture;
  if (u_lobe < mixture.guide) {
    scatter_by_guide(v, u_direction, next);
    return true;
  }
  if (mixture.guide > 0) {
    u_lobe = (u_lobe - mixture.guide) / (1 - mixture.guide);
    if (mixture.base == 0) u_lobe *= 1 - v.parts.base_chance;  // lobes alone
  }
  // Apart, so that the compiler keeps a Lambert surface's sample in registers.
  if (v.kind == BsdfKind::kDiffuse) {
    const std::optional<BsdfSample> s = Diffuse::sample_at(v.bsdf_at.sp, v.bsdf_at.wo, u_direction);
    if (s) scatter_by_bsdf(v, *s, next);
    return s.has_value();
  }
  const std::optional<BsdfSample> s = v.bsdf.sample(v.bsdf_at, u_lobe, u_direction);
  if (s) scatter_by_bsdf(v, *s, next);
  return s.has_value();
}

inline void PathTracer::scatter_by_bsdf(const PathVertex& v, const BsdfSample& s,
                                        ScatterSample& next) {
  const GuideMixture& mixture = v.mixture;
  next.wi = v.frame.to_world(s.wi);
  next.weight = s.weight;
  next.pdf_w = next.bsdf_pdf_w = next.unguided_pdf_w = s.pdf_w;
  next.base_pdf_w = s.base_pdf_w;
  next.lobes_weight = s.weight - s.base_weight;
  next.delta = s.delta;
  if (!next.delta && (mixture.guide > 0 || (v.learns_bsdf && v.parts.base_chance < 1))) {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    next.guide_pdf_w = guide_->pdf_w(v.at, next.wi);
  }
  if (mixture.guide > 0) {
    float rescaled = 1 / mixture.lobes;
    if (!next.delta) {
      next.pdf_w = mixture.pdf_w(next.guide_pdf_w, s.base_pdf_w, s.pdf_w - s.base_pdf_w);
      rescaled = s.pdf_w / next.pdf_w;
    }
    next.weight *= rescaled;
    next.lobes_weight *= rescaled;
  }
  if (!v.sides_agree(next.wi, s.wi)) next.weight = next.lobes_weight = {};
}

inline void PathTracer::scatter_by_guide(const PathVertex& v, Vec2 u_direction,
                                         ScatterSample& next) {
  GuideSample s;
  {
    const CycleScope guiding(timed_, counters_.timed_guiding);
    s = guide_->sample(v.at, u_direction);
  }
  const Vec3 wi_local = v.frame.to_local(s.wi);
  const BsdfEval eval = v.eval(wi_local);
  next.wi = s.wi;
  next.pdf_w = v.mixture.pdf_w(s.pdf_w, eval.base_pdf_w, eval.pdf_w - eval.base_pdf_w);
  next.bsdf_pdf_w = next.unguided_pdf_w = eval.pdf_w;
  next.base_pdf_w = eval.base_pdf_w;
  next.guide_pdf_w = s.pdf_w;
  if (!eval.f_cos.is_black() && v.sides_agree(s.wi, wi_local)) {
    next.weight = eval.f_cos / next.pdf_w;
    next.lobes_weight = (eval.f_cos - eval.base_f_cos) / next.pdf_w;
  }
}

}  // namespace qray
