// The table that grows where its data supports it (docs/guiding.md): places by a SpatialTree,
// directions by DirectionTrees, integer sums of what each direction was paid, and of what arrives
// in all, which Russian roulette reads (path.cpp); and which lights send how much where. How it
// grows between passes is in adaptive_growth.cpp; saving, loading and merging its tables in
// adaptive_table.cpp; copies of it for other processes in adaptive_share.cpp.
//
// Sums are added to while a pass runs, each state's behind its lock: neither threads nor order
// change a bit. Radiance counts in units of the scene's brightest light.
#pragma once

#include <algorithm>
#include <memory>

#include "core/base/spin_lock.h"
#include "core/guide/arrival_sums.h"
#include "core/guide/direction_tree.h"
#include "core/guide/guide.h"
#include "core/guide/spatial_tree.h"

namespace qray {

struct AdaptiveRecord;

class AdaptiveGuide final : public Guide, private GuideShare {
 public:
  explicit AdaptiveGuide(const GuideSetup& setup);

  std::string_view method() const override { return "adaptive"; }
  bool unbiased() const override { return true; }

  GuidePoint find(Vec3 p, Vec3 n) const override;
  void find_each(const Vec3Lanes& p, const Vec3Lanes& n, uint32_t lanes,
                 GuidePoints& found) const override;
  GuideMixture mixture(const GuidePoint& point, const GuidedSurface& surface) const override;
  GuideSample sample(const GuidePoint& point, Vec2 u) const override;
  float pdf_w(const GuidePoint& point, Vec3 wi) const override;
  void sample_each(const GuidePoints& points, const Vec2Lanes& u, uint32_t lanes, Vec3Lanes& wi,
                   FloatLanes& pdf_w) const override;
  void pdf_w_each(const GuidePoints& points, const Vec3Lanes& wi, uint32_t lanes,
                  FloatLanes& pdf_w) const override;
  const LightImportance* light_importance() const override { return &lights_; }
  bool expects() const override { return true; }
  bool aims_at_caustics() const override { return true; }
  GuideExpectation expectation(const GuidePoint& point) const override {
    const State& state = states_[point.state.value];
    return {state.credible, state.arriving, state.deviation};
  }
  uint32_t expect_each(const GuidePoints& points, uint32_t lanes,
                       ExpectationLanes& expected) const override;

  float gain(const GuidePoint& point) const override;
  std::vector<DirectionCell> directions(const GuidePoint& point) const override;
  StateSummary summary(const GuidePoint& point) const override;
  std::vector<GuidePoint> known_points(size_t most) const override;

  GuideNeeds needs() const override { return {.bsdf = true}; }
  std::unique_ptr<GuideDelta> make_delta() const override;
  void record(std::span<const GuideVertex> path, GuideDelta& delta) const override;
  void update(GuideDelta& delta) override;
  void end_pass() override;
  void stop_growing() override { grows_ = false; }
  GuideShare* share() override { return this; }

  GuideStats stats() const override;
  GuideWorth worth() const override { return worth_; }
  void set_worth(const GuideWorth& worth) override {
    worth_ = {std::min(worth.efficiency_gain, GuideWorth::kMost),
              std::min(worth.unguided_cost, GuideWorth::kMost)};
  }
  std::vector<TableSection> save() const override;
  Status load(std::span<const TableSection> sections) override;
  void save_state(SnapshotWriter& out) const override;
  void load_state(SnapshotReader& in) override;
  Status merge(const GuideTable& other) override;
  void fade(int times) override;
  void doubt() override;
  void set_lights(const LightClusters& clusters) override;

 private:
  using Cell = DirectionTrees::Cell;
  using Cells = DirectionTrees::Cells;

  struct Delta final : GuideDelta {
    uint64_t samples = 0;  // recorded: all else went into the sums at once
  };
  // What sampling reads of a leaf of a face's tree.
  struct State {
    uint64_t key = 0;
    uint32_t root = 0;  // of its directions
    Rgb arriving;       // radiance
    float deviation = 0;
    float lobe_share = LobeShares::kUnknown;  // of the guide in the directions of rough lobes
    bool credible = false, guides = false;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.key, self.root, self.arriving, self.deviation, self.lobe_share, self.credible,
              self.guides);
    }
  };
  // What is learned of it.
  struct alignas(64) Sums : ArrivalSums {
    SpinLock lock;  // of the state's directions too
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      for (auto* v : self.all()) archive(*v);
    }
  };

  static constexpr int64_t kShareOne = 1 << 16;  // the unit of shares and of what is kept
  // Of what a rebuild makes the trees.
  struct Growth {
    struct Part {
      int64_t share = kShareOne;  // of the tree that the state has
      int64_t keep = kShareOne;   // of that share, and of the state's sums
      bool stays = false;         // the pass brought too little: it all waits for more
    };
    std::vector<Part> parts;  // each state's
    size_t room = 0;          // bytes
  };
  void save_copy(SnapshotWriter& out) const override;
  void load_copy(SnapshotReader& in) override;
  Bytes take_learned() override;
  bool add_learned(std::span<const uint8_t> learned) override;

  template <class Self, class Archive>
  static void exchange_state(Self& self, Archive& archive);
  int64_t kept(size_t state) const;  // of kShareOne: of its sums, at the end of a pass
  Growth whole_trees(int64_t keep = kShareOne) const;
  Growth news() const;  // at the end of a pass
  void cut_places(Growth& growth);
  AdaptiveGuide(const AdaptiveGuide& o);
  void cut(uint32_t leaf, Growth& growth);
  void add_states();                     // of leaves that the tree has got
  size_t rebuild(const Growth& growth);  // how many trees the room held back
  void index();
  size_t bytes() const;
  void refine_as(const AdaptiveGuide& other);
  DirectionTrees::Roots roots_of(const GuidePoints& points, uint32_t lanes) const;
  void summarize(State& state, const Sums& sums) const;
  void choose_lobe_shares();
  void put(State& state, Cells cells, DirectionTrees& to) const;
  void load_record(uint32_t leaf, AdaptiveRecord&& record);

  AdaptiveParams params_;
  size_t max_bytes_;
  double radiance_unit_;            // a power of two, at least the brightest light's luminance
  SpatialTree tree_;                // one a face
  std::vector<State> states_;       // by the tree's leaf
  mutable std::vector<Sums> sums_;  // parallel
  std::vector<int64_t> known_;      // parallel: samples in the sums, before the pass
  mutable DirectionTrees directions_;
  LightImportance lights_;
  uint64_t samples_seen_ = 0;
  uint64_t refused_ = 0;
  bool grows_ = true;
  GuideWorth worth_;
};

}  // namespace qray
