// Practical Path Guiding (Mueller, Gross, Novak 2017) with the improvements of its author's course
// notes (Mueller 2019, "Practical Path Guiding in Production"): a binary tree over space, in each
// of its leaves a quadtree over the sphere of directions (by cos theta and phi, which keeps areas);
// iterations that double, each sampling what the one before learned; radiance without nee's share;
// the chance to draw from the tree rather than the BSDF learned per leaf (Adam, on the KL
// divergence); samples splatted at a place and direction moved at random within a leaf's size.
// Its passes' combination by inverse variance is the renderer's (render_loop.cpp).
// Its tables hold densities without the weight behind each, so two of them cannot be merged; saving
// and loading them is in ppg_table.cpp.
#pragma once

#include "core/base/spin_lock.h"
#include "core/guide/direction_tree.h"
#include "core/guide/guide.h"
#include "core/guide/spatial_tree.h"

namespace qray {

struct PpgRecord;

class PpgGuide final : public Guide {
 public:
  explicit PpgGuide(const GuideSetup& setup);

  std::string_view method() const override { return "ppg"; }
  bool unbiased() const override { return true; }

  GuidePoint find(Vec3 p, Vec3 n) const override;
  GuideMixture mixture(const GuidePoint& point, const GuidedSurface& surface) const override;
  GuideSample sample(const GuidePoint& point, Vec2 u) const override;
  float pdf_w(const GuidePoint& point, Vec3 wi) const override;
  // Over directions drawn uniformly from the sphere.
  float gain(const GuidePoint& point) const override;
  std::vector<DirectionCell> directions(const GuidePoint& point) const override;
  StateSummary summary(const GuidePoint& point) const override;
  std::vector<GuidePoint> known_points(size_t most) const override;

  GuideNeeds needs() const override { return {.bsdf = true}; }
  std::unique_ptr<GuideDelta> make_delta() const override;
  void record(std::span<const GuideVertex> path, GuideDelta& delta) const override;
  void update(GuideDelta& delta) override;
  void end_pass() override;

  GuideStats stats() const override;
  std::vector<TableSection> save() const override;
  Status load(std::span<const TableSection> sections) override;
  void save_state(SnapshotWriter& out) const override;
  void load_state(SnapshotReader& in) override;
  Status merge(const GuideTable& other) override { return cannot_merge(*this, other); }

 private:
  struct Leaf {
    uint32_t root = 0;  // of its directions
    bool ready = false;
    int64_t samples = 0;  // of this iteration
    float paid = 0;       // mean, radiance units x steradians: of the last iteration
    // Adam's state; the chance of the guide is 1 / (1 + exp(-theta)).
    float fraction = 0.5f;  // that
    float theta = 0, first_moment = 0, second_moment = 0;
    uint32_t steps = 0;
    mutable SpinLock lock;  // of what is added to its directions
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.root, self.ready, self.samples, self.paid, self.fraction, self.theta,
              self.first_moment, self.second_moment, self.steps);
    }
  };
  struct Delta;

  template <class Self, class Archive>
  static void exchange_state(Self& self, Archive& archive);
  size_t bytes() const;
  void index();
  void step(Leaf& leaf, float gradient);
  void load_record(uint32_t place, const PpgRecord& record);
  GuidePoint point_of(uint32_t leaf) const;  // over the sphere: a leaf knows no normal

  size_t max_bytes_;
  double radiance_unit_;
  SpatialTree tree_;
  std::vector<Leaf> leaves_;  // by the tree's leaf
  mutable DirectionTrees directions_;
  int64_t iteration_samples_ = 0, last_iteration_samples_ = 0;
  int iteration_ = 0;
  uint64_t samples_seen_ = 0, refused_ = 0;
};

}  // namespace qray
