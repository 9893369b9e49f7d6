// The thesis' method: Q-learning over 26 directions (section 4.2) and Algorithm 1's choice of the
// reflecting direction (section 4.3). As `huang` the choice is divided by its exact density; as
// `huang-published` it is treated as the uniform choice it is not, as the thesis prints it, which
// brightens the picture. Saving, loading and merging its tables is in huang_table.cpp.
//
// The exact density. M = max_a Q_a, mu_a the share of the hemisphere nearest to
// direction a, R_j = sum_a mu_a [Q_a <= j M/8], S_7 = 1, S_k = S_{k+1} R_{k+1}:
//   p(d) = w_a(d) / (2 pi),  w_a = S_1 + sum_{k=2..7} S_k [Q_a > k M/8].
#pragma once

#include <array>
#include <unordered_map>

#include "core/guide/directions26.h"
#include "core/guide/guide.h"
#include "core/guide/key_index.h"
#include "core/guide/surface_grid.h"

namespace qray {

class HuangGuide final : public Guide {
 public:
  enum class Density { kExact, kAsPublished };
  using Values = std::array<float, kDirections26>;

  HuangGuide(Density density, const Bounds3& bounds, const HuangParams& params,
             size_t max_bytes = kDefaultTableBytes);

  std::string_view method() const override;
  bool unbiased() const override { return density_ == Density::kExact; }

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
  // Values become means over all updates.
  Status merge(const GuideTable& other) override;

  // The learned values and how often each was updated; for views and tests.
  const Values* values(uint64_t key) const;
  // Sets one state's values as if learned; they rule after end_pass(). For tests and figures.
  void set_values(uint64_t key, const Values& values);
  // Algorithm 1's relative density w_a for given values and shares of the hemisphere.
  static Values density_weights(const Values& values, const Values& shares);

 private:
  struct Learned {
    Values q{};
    std::array<uint32_t, kDirections26> count{};
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.q, self.count);
    }
  };
  struct Frozen {
    Values weight;  // w_a
    float gain = 1;
    std::array<uint8_t, kDirections26> level{};  // how many of M/8..7M/8 lie below Q_a
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.weight, self.gain, self.level);
    }
  };
  struct Delta;

  template <class Self, class Archive>
  static void exchange_state(Self& self, Archive& archive);
  StateId learned_state(uint64_t key);    // invalid: there is no room for a new one
  void mark(StateId state);               // end_pass() will freeze it
  const Values& shares_of(uint64_t key);  // of the hemisphere about the key's normal
  Status check_densities();

  Density density_;
  HuangParams params_;
  SurfaceGrid grid_;
  size_t max_bytes_;
  size_t max_states_;
  uint64_t samples_seen_ = 0, refused_ = 0;

  KeyIndex learned_index_;  // with learned_ and dirty_: what update() writes
  std::vector<Learned> learned_;
  std::vector<uint8_t> is_dirty_;
  std::vector<uint32_t> dirty_;

  KeyIndex frozen_index_;  // with frozen_: what sampling reads; a copy, made by end_pass()
  std::vector<Frozen> frozen_;
  std::unordered_map<uint32_t, Values> shares_;  // by the key's normal bits
};

}  // namespace qray
