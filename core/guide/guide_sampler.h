// The part of a guide that draws directions, which is all that a path tracer needs. It may be
// wrong, never biasing: its exact pdf is always divided out (`huang-published` alone pretends one,
// and says so by unbiased()). Any thread, also while the guide learns, but not during end_pass().
#pragma once

#include <array>

#include "core/guide/guide_point.h"
#include "core/guide/light_importance.h"
#include "core/math/wide.h"

namespace qray {

using GuidePoints = std::array<GuidePoint, kWidth>;
struct ExpectationLanes {  // GuideExpectation
  RgbLanes arriving;
  FloatLanes deviation;
};

class GuideSampler {
 public:
  virtual ~GuideSampler() = default;

  // Whether pdf_w() is the density that sample() draws with.
  virtual bool unbiased() const = 0;

  // p: metres. n: unit geometric normal on the side that the light is reflected to. The answer's
  // domain holds the directions that the other calls are about.
  virtual GuidePoint find(Vec3 p, Vec3 n) const = 0;
  // The same of several points, those whose bits are set. A guide may search for them in turns, so
  // that none waits for what memory brings the others.
  virtual void find_each(const Vec3Lanes& p, const Vec3Lanes& n, uint32_t lanes,
                         GuidePoints& found) const {
    for_each_lane(lanes, [&](int i) { found[static_cast<size_t>(i)] = find(p[i], n[i]); });
  }
  // How directions are drawn there, on such a surface.
  virtual GuideMixture mixture(const GuidePoint& point, const GuidedSurface& surface) const = 0;
  // These two are asked only where the mixture has a guide. u: uniform in [0, 1)^2.
  virtual GuideSample sample(const GuidePoint& point, Vec2 u) const = 0;
  // Integrates to 1 over the point's domain, and is 0 outside of it.
  virtual float pdf_w(const GuidePoint& point, Vec3 wi) const = 0;
  // The same at several points, those whose bits are set. Others' answers mean nothing.
  virtual void sample_each(const GuidePoints& points, const Vec2Lanes& u, uint32_t lanes,
                           Vec3Lanes& wi, FloatLanes& pdf_w) const {
    for_each_lane(lanes, [&](int i) {
      const GuideSample s = sample(points[static_cast<size_t>(i)], u[i]);
      wi.set(i, s.wi);
      pdf_w[i] = s.pdf_w;
    });
  }
  virtual void pdf_w_each(const GuidePoints& points, const Vec3Lanes& wi, uint32_t lanes,
                          FloatLanes& pdf_w) const {
    for_each_lane(lanes,
                  [&](int i) { pdf_w[i] = this->pdf_w(points[static_cast<size_t>(i)], wi[i]); });
  }

  // Which lights send how much where; null: the method does not learn it.
  virtual const LightImportance* light_importance() const { return nullptr; }

  // Whether its paths may also aim at where mirrors and glass send light from.
  virtual bool aims_at_caustics() const { return false; }

  // Whether the method has expectations at all, and what it expects.
  virtual bool expects() const { return false; }
  virtual GuideExpectation expectation(const GuidePoint&) const { return {}; }
  // The same at several points, those whose bits are set. Those where it is credible come back.
  virtual uint32_t expect_each(const GuidePoints& points, uint32_t lanes,
                               ExpectationLanes& expected) const {
    uint32_t credible = 0;
    for_each_lane(lanes, [&](int i) {
      const GuideExpectation e = expectation(points[static_cast<size_t>(i)]);
      expected.arriving.set(i, e.arriving);
      expected.deviation[i] = e.deviation;
      if (e.credible) credible |= 1u << i;
    });
    return credible;
  }
};

}  // namespace qray
