// How much more, or less, clusters of lights send to a place than is expected of them: what is in
// their way, how they shine, what the surfaces there make of it. Next event estimation picks a
// cluster in proportion to its prior times the root of the second moment of what it sent over what
// was expected (after Vevoda et al. 2018, "Bayesian online regression for adaptive direct
// illumination sampling", and Rath et al. 2020, whose target is the root of a second moment). No
// cluster that may send something is ever left out.
//
// Places are the cells of a coarse grid, 8 along each axis of the scene's bounds, with the face
// that the normal points at. Finer ones, of 16 and 32, gained nothing and learn later.
//
// Sums are whole numbers that any thread may add to while a pass runs: neither threads nor order
// change a bit. What was learned rules from the next end_pass() on.
#pragma once

#include <span>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/base/snapshot.h"
#include "core/guide/light_clusters.h"

namespace qray {

class LightImportance {
 public:
  static constexpr int kCells = 8, kFaces = 6;
  static constexpr uint32_t kPlaces = kCells * kCells * kCells * kFaces;

  LightImportance() = default;
  explicit LightImportance(LightClusters clusters);

  const LightClusters& clusters() const { return clusters_; }
  bool empty() const { return clusters_.groups.empty(); }
  static size_t bytes_of(const LightClusters& clusters);
  size_t bytes() const { return bytes_of(clusters_); }

  // n: of the surface, or zero where light from all sides counts. Points outside count to the
  // nearest cell.
  uint32_t place(Vec3 p, Vec3 n) const;
  // For each cluster, group by group: where priors are known, the chance of the group's clusters up
  // to this one; else a factor over 0 of its weight. Null: nothing is known there that would change
  // a pick.
  const float* weights(uint32_t place) const {
    return known_[place] ? &weights_[size_t{place} * count_] : nullptr;
  }

  // A light was picked through these clusters, and sent `estimate` (luminance over the chance of
  // its pick; 0: something was in the way).
  void record(uint32_t place, std::span<const ClusterPick> picks, float estimate) const;
  void end_pass();
  void fade(int times);  // what is known counts a `times`-th

  // Adds what another has learned of the same clusters; false: they are others.
  bool merge(const LightImportance& other);

  // Copies in other processes (guide_share.h): what sampling reads, of places that are known; what
  // was learned, which is then forgotten; and that added, false if it is none of these clusters.
  void save_copy(SnapshotWriter& out) const;
  void load_copy(SnapshotReader& in);
  void take_learned(ByteWriter& out);
  struct Learned {
    struct Sum {
      size_t index;  // place and cluster
      uint64_t square;
      uint32_t count;
    };
    std::vector<Sum> sums;
  };
  bool read_learned(ByteReader& in, Learned& learned) const;
  void add(const Learned& learned);

  // All but the clusters. What was read may not fit.
  bool fits() const;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.squares_, self.counts_, self.known_, self.weights_);
  }

  // A table's section (proto/table_file.md). kCorrupt.
  bool has_learned() const;
  Bytes save() const;
  static Result<LightImportance> load(std::span<const uint8_t> bytes);

 private:
  void solve(uint32_t place);
  void write_learned(ByteWriter& out) const;
  void forget();

  LightClusters clusters_;
  size_t count_ = 0;  // of clusters
  // By place, then cluster: sums of squares in 2^-30, and of how many picks.
  mutable std::vector<uint64_t> squares_;
  mutable std::vector<uint32_t> counts_;
  std::vector<uint8_t> known_;  // by place: its weights change picks
  std::vector<float> weights_;  // as the sums
};

}  // namespace qray
