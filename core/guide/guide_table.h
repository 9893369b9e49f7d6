// The part of a guide that outlives its render: what it learned as a table, for files, checkpoints
// and merging. One thread, while the guide neither learns nor samples; const calls between passes.
#pragma once

#include <compare>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/snapshot.h"
#include "core/guide/light_clusters.h"
#include "core/guide/table_file.h"

namespace qray {

struct GuideStats {
  size_t states = 0;
  size_t direction_nodes = 0;  // of trees, where the method has them
  size_t bytes = 0;            // of memory
  uint64_t samples_seen = 0;   // transitions learned from, in all jobs
  uint64_t refused = 0;        // transitions that found no room for their state: the table is full
};

// What the guide was worth to the last job that learned and measured it (core/render/guide_gate.h).
struct GuideWorth {
  double efficiency_gain = 0;           // over paths without the guide; 0: not known
  double unguided_cost = 0;             // of such a path over one with the guide; 0: not known
  static constexpr double kMost = 1e6;  // of either, in a table
  auto operator<=>(const GuideWorth&) const = default;
};

class GuideTable {
 public:
  virtual ~GuideTable() = default;

  virtual std::string_view method() const = 0;
  virtual GuideStats stats() const = 0;
  // Goes with the table, where the method keeps it.
  virtual GuideWorth worth() const { return {}; }
  virtual void set_worth(const GuideWorth&) {}

  virtual std::vector<TableSection> save() const = 0;
  // Into a fresh guide. kCorrupt: not a table of this method; kConflict: of another grid or cube;
  // kTooLarge: over the guide's memory.
  virtual Status load(std::span<const TableSection> sections) = 0;

  // All of it, within a pass too: one that reads what another wrote goes on to the same bits. Only
  // between tiles. `in` tells what does not fit by its ok(); this one is then of no more use.
  virtual void save_state(SnapshotWriter& out) const = 0;
  virtual void load_state(SnapshotReader& in) = 0;

  // Adds what `other` learned in the same scene, between passes; it rules sampling at once. Which
  // of two is added to which changes no bit of what is saved. kInvalid: another method's, or what
  // this one's tables hold cannot be added; kConflict: another grid; kTooLarge: no room. An error
  // leaves the guide as it was.
  virtual Status merge(const GuideTable& other) = 0;
  // Where the method counts, what it knows counts a `times`-th from now on: surfaces or lights have
  // moved a little.
  virtual void fade(int times) { (void)times; }
  // The scene has changed since the table was learned: what it knows counts a sixteenth, and what
  // it is worth is not known any more.
  virtual void doubt() {}
  // The scene's lights are others now: what was learned of them is of no use.
  virtual void set_lights(const LightClusters&) {}
};

// kInvalid: tables of these two methods, or any of this one, cannot be merged.
Error cannot_merge(const GuideTable& into, const GuideTable& other);

}  // namespace qray
