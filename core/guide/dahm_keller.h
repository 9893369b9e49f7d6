// "Learning Light Transport the Reinforced Way" (Dahm and Keller 2017): for each state the radiance
// Q arriving through each of 64 equal cells of the hemisphere; directions drawn in proportion to Q,
// uniformly within a cell; the expected update
//   Q(x, w) <- (1 - a) Q(x, w) + a (L_e(y, -w) + integral f_s(w_i, y, -w) cos(theta_i) Q(y, w_i)
//   dw_i)
// with a = 1 / (1 + visits) and the integral summed over y's cells, its BSDF taken for Lambert's.
// States are a grid cell with the face's normal (surface_grid.h) where the paper has the nearest of
// points scattered over the surfaces, and half of the directions are the BSDF's. The density is
// known, so the estimator is unbiased.
#pragma once

#include <array>

#include "core/guide/guide.h"
#include "core/guide/key_index.h"
#include "core/guide/surface_grid.h"

namespace qray {

class DahmKellerGuide final : public Guide {
 public:
  static constexpr int kSide = 8, kCells = kSide * kSide;
  using Values = std::array<float, kCells>;

  explicit DahmKellerGuide(const GuideSetup& setup);

  std::string_view method() const override { return "dahm-keller"; }
  bool unbiased() const override { return true; }

  GuidePoint find(Vec3 p, Vec3 n) const override;
  GuideMixture mixture(const GuidePoint& point, const GuidedSurface& surface) const override;
  GuideSample sample(const GuidePoint& point, Vec2 u) const override;
  float pdf_w(const GuidePoint& point, Vec3 wi) const override;
  float gain(const GuidePoint& point) const override;
  std::vector<DirectionCell> directions(const GuidePoint& point) const override;
  StateSummary summary(const GuidePoint& point) const override;
  std::vector<GuidePoint> known_points(size_t most) const override;

  GuideNeeds needs() const override { return {.transition = true}; }
  std::unique_ptr<GuideDelta> make_delta() const override;
  void record(std::span<const GuideVertex> path, GuideDelta& delta) const override;
  void update(GuideDelta& delta) override;
  void end_pass() override;

  GuideStats stats() const override;
  std::vector<TableSection> save() const override;
  Status load(std::span<const TableSection> sections) override;
  void save_state(SnapshotWriter& out) const override;
  void load_state(SnapshotReader& in) override;
  // Values become means over all visits.
  Status merge(const GuideTable& other) override;

  const Values* values(uint64_t key) const;  // learned; for tests

 private:
  struct Learned {
    Values q{};
    std::array<uint32_t, kCells> visits{};
    float scattered = 0;  // mean over the projected hemisphere of q
    bool dirty = false;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.q, self.visits, self.scattered, self.dirty);
    }
  };
  struct Frozen {
    std::array<float, kCells> cdf;  // of the cells up to and with this one; the last is 1
    float gain = 1;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.cdf, self.gain);
    }
  };
  struct Delta;

  template <class Self, class Archive>
  static void exchange_state(Self& self, Archive& archive);
  static int cell_of(Vec3 local);
  Learned& learned_state(uint64_t key);  // there is room for it; end_pass() will freeze it
  void freeze(uint32_t index);

  SurfaceGrid grid_;
  size_t max_bytes_, max_states_;
  uint64_t samples_seen_ = 0, refused_ = 0;
  KeyIndex learned_index_;  // with learned_: what update() writes
  std::vector<Learned> learned_;
  std::vector<uint32_t> dirty_;
  KeyIndex frozen_index_;  // with frozen_: what sampling reads; a copy, made by end_pass()
  std::vector<Frozen> frozen_;
};

}  // namespace qray
