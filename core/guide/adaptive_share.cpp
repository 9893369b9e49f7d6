// Copies of AdaptiveGuide that sample units of a pass in other processes (guide_share.h).
//
// What a unit learned: how many samples were recorded; then of each state that was hit its distance
// from the one before, from 1 on, and its sums, behind the last one a 0; then the same of clusters
// of lights (LightImportance::take_learned()) and of nodes of the direction trees
// (DirectionTrees::take_sums()). All are varints.
#include <utility>

#include "core/base/varint.h"
#include "core/guide/adaptive.h"

namespace qray {

void AdaptiveGuide::save_copy(SnapshotWriter& out) const {
  SpatialTree::exchange_cuts(tree_, out);
  out(states_);
  lights_.save_copy(out);
  DirectionTrees::exchange_trees(directions_, out);
}

void AdaptiveGuide::load_copy(SnapshotReader& in) {
  SpatialTree::exchange_cuts(tree_, in);
  in(states_);
  lights_.load_copy(in);
  DirectionTrees::exchange_trees(directions_, in);
  if (states_.size() != tree_.leaves()) in.fail();
  for (const State& state : states_)
    if (state.root >= directions_.nodes()) in.fail();
  if (!in.ok()) return;
  tree_.index_top();
  directions_.empty_sums();
  sums_ = std::vector<Sums>(states_.size());
  known_.assign(states_.size(), 0);
  samples_seen_ = 0;
}

Bytes AdaptiveGuide::take_learned() {
  ByteWriter out;
  put_varint(out, std::exchange(samples_seen_, 0));
  size_t next = 0;  // behind the last one written
  for (size_t s = 0; s < sums_.size(); ++s) {
    if (sums_[s].n == 0) continue;
    put_varint(out, s + 1 - next);
    next = s + 1;
    for (const int64_t* v : std::as_const(sums_[s]).all()) put_signed_varint(out, *v);
    sums_[s].scale(0, 1);
  }
  put_varint(out, 0);
  lights_.take_learned(out);
  directions_.take_sums(out);
  return out.take();
}

bool AdaptiveGuide::add_learned(std::span<const uint8_t> learned) {
  ByteReader in(learned);
  uint64_t samples = 0, next = 0;
  std::vector<std::pair<size_t, ArrivalSums>> arrived;
  if (!get_varint(in, samples)) return false;
  for (;;) {
    uint64_t step = 0;
    if (!get_varint(in, step) || step > sums_.size() - next) return false;
    if (step == 0) break;
    next += step;
    auto& [state, sums] = arrived.emplace_back();
    state = next - 1;
    for (int64_t* v : sums.all())
      if (!get_signed_varint(in, *v)) return false;
  }
  LightImportance::Learned of_lights;
  if (!lights_.read_learned(in, of_lights)) return false;
  std::vector<DirectionTrees::Added> added;
  if (!directions_.read_sums(in, added) || in.remaining() > 0) return false;
  samples_seen_ += samples;
  for (const auto& [state, sums] : arrived) sums_[state] += sums;
  lights_.add(of_lights);
  directions_.add_sums(added);
  return true;
}

}  // namespace qray
