// How often a rough lobe leaves its direction to the guide, decided by what was learned at a place.
// Where the lobe is broad or light comes from few directions the guide is better, else the lobe's
// own sampling. Each path that was learned from tells what the second moment of its contribution
// would have been under each of a few shares, whatever share drew it (as Meyer et al. 2024, "MARS",
// compare techniques by second moments). No share is 0: rare light that no sample has met yet is
// what the guide may find first. Sums in fixed point: no order changes a bit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/guide/guide_learner.h"

namespace qray {

struct LobeShares {
  static constexpr std::array<float, 4> kShares{0.1f, 0.25f, 0.5f, 0.8f};
  static constexpr float kUnknown = 0.25f;  // as long as nothing was learned
  static constexpr double kPriorSamples = 500;
  using Means = std::array<double, kShares.size()>;  // over all places, of a sample

  // Of each share: the sum of (contribution / what was expected)^2 x (density drawn with / density
  // with that share), times kOne.
  std::array<int64_t, kShares.size()> moments{};

  // One sample, where this luminance is expected to arrive, with this deviation. What few samples
  // show of rare light is bounded here, never in a picture. A surface without rough lobes tells
  // nothing.
  static LobeShares of(const GuideVertex& v, float arriving, float deviation) {
    constexpr float kOne = 0x1p16f, kMostOverExpected = 8, kMostRatio = 64;
    LobeShares one;
    const GuideVertex::BsdfPart& bsdf = v.bsdf;
    if (bsdf.surface.smooth || bsdf.surface.base_chance >= 1) return one;
    const float contribution = bsdf.f_cos / v.pdf_w * luminance(v.arriving);
    const float relative = contribution / (bsdf.albedo * std::hypot(arriving, deviation));
    if (!(relative > 0)) return one;  // NaN too
    const float square = sqr(std::min(relative, kMostOverExpected)) * kOne;
    for (size_t i = 0; i < kShares.size(); ++i) {
      const float pdf_w = GuideMixture::in_place_of_base(bsdf.surface.base_chance, kShares[i])
                              .pdf_w(bsdf.guide_pdf_w, 0, bsdf.pdf_w - bsdf.base_pdf_w);
      const float ratio = pdf_w * kMostRatio > v.pdf_w ? v.pdf_w / pdf_w : kMostRatio;
      one.moments[i] = static_cast<int64_t>(square * ratio);
    }
    return one;
  }

  LobeShares& operator+=(const LobeShares& o) {
    for (size_t i = 0; i < moments.size(); ++i) moments[i] += o.moments[i];
    return *this;
  }

  // The share of the least second moment, few samples being completed by what is usual.
  float best(const Means& usual) const {
    double least = 0;
    float share = kUnknown;
    for (size_t i = 0; i < kShares.size(); ++i) {
      const double moment = static_cast<double>(moments[i]) + kPriorSamples * usual[i];
      if (!(moment > 0) || (least > 0 && moment >= least)) continue;
      least = moment;
      share = kShares[i];
    }
    return share;
  }
};

}  // namespace qray
