// How AdaptiveGuide's places and directions grow between passes, within its memory.
#include <algorithm>
#include <utility>

#include "core/guide/adaptive.h"

namespace qray {
namespace {

constexpr int64_t kMinSamples = 64;  // before a state is believed

}  // namespace

void AdaptiveGuide::summarize(State& state, const Sums& sums) const {
  if (sums.n < kMinSamples) return;
  const float unit = static_cast<float>(radiance_unit_);
  state.arriving = sums.mean() * unit;
  state.deviation = static_cast<float>(sums.deviation()) * unit;
  state.credible = true;
}

// The halves share what the whole knew as they shared its samples.
void AdaptiveGuide::cut(uint32_t leaf, std::vector<int64_t>& shares) {
  const int64_t n = sums_[leaf].n;
  const int64_t part = n > 0 ? DirectionTrees::scaled(kShareOne, sums_[leaf].n_upper, n) : 0;
  tree_.split(leaf);
  State half = states_[leaf];
  Sums sums = sums_[leaf];
  sums.scale(part, kShareOne);
  sums_[leaf] -= sums;
  const int64_t share = DirectionTrees::scaled(shares[leaf], part, kShareOne);
  shares[leaf] -= share;
  // Where in each half its samples lay is not known: on both sides alike.
  sums_[leaf].n_upper = sums_[leaf].n / 2;
  sums.n_upper = sums.n / 2;
  if (part == 0) half.credible = false;
  if (part == kShareOne) states_[leaf].credible = false;
  states_.push_back(half);
  sums_.push_back(sums);
  shares.push_back(share);
}

// Gives the state, of which it is known whether it is credible, its directions.
void AdaptiveGuide::put(State& state, Cells cells, DirectionTrees& to) const {
  DirectionTrees::add_uniform(cells, params_.uniform);
  state.root = to.put(cells);
  state.guides = state.credible && to.second_moment(state.root) >= params_.min_gain;
}

AdaptiveGuide::Growth AdaptiveGuide::whole_trees() const {
  return {std::vector<int64_t>(states_.size(), kShareOne)};
}

AdaptiveGuide::Growth AdaptiveGuide::cut_places(size_t room) {
  Growth growth = whole_trees();
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    size_t half = 0;  // bytes
    while (static_cast<double>(sums_[leaf].n) > params_.split_samples &&
           tree_.depth(leaf) < SpatialTree::kMaxDepth) {
      if (half == 0)
        half = sizeof(State) + sizeof(Sums) + SpatialTree::kMaxLeafBytes +
               DirectionTrees::bytes_of(directions_.take(states_[leaf].root));
      if (half > room) {
        refused_ += grows_;
        break;
      }
      room -= half;
      cut(leaf, growth.shares);
    }
  }
  growth.room = room;
  return growth;
}

// A pass that is long against what is known displaces it, since it was guided better; short ones,
// with which a job starts from a table, only add to it.
int64_t AdaptiveGuide::kept_share() {
  int64_t all = 0;
  for (const Sums& sums : sums_) all += sums.n;
  const auto pass = static_cast<double>(samples_seen_ - seen_before_pass_);
  seen_before_pass_ = samples_seen_;
  const double old = all > 0 ? 1 - pass / static_cast<double>(all) : 0;
  return static_cast<int64_t>(std::clamp(old, static_cast<double>(params_.keep), 1.0) *
                              static_cast<double>(kShareOne));
}

// Every tree is made anew, side by side in memory: from what was learned, cut finer where the data
// supports it and there is room, then faded.
void AdaptiveGuide::end_pass() {
  // An eighth is left for the index over places.
  tree_.index_top(0);
  const size_t most = max_bytes_ - max_bytes_ / 8, taken = bytes();
  if (taken > max_bytes_) {  // not even for the places to begin with
    for (Sums& sums : sums_) sums.scale(0, 1);
    ++refused_;
    return;
  }
  const size_t room = grows_ && most > taken ? most - taken : 0;
  // The means first: halves know as much as the whole.
  for (size_t s = 0; s < states_.size(); ++s) summarize(states_[s], sums_[s]);
  const int64_t keep = kept_share();
  const size_t held_back = rebuild(cut_places(room), keep);
  if (grows_) refused_ += held_back;
}

size_t AdaptiveGuide::rebuild(const Growth& growth, int64_t keep) {
  size_t room = growth.room;
  DirectionTrees next;
  size_t held_back = 0;
  next.reserve(directions_.nodes());
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    State& state = states_[leaf];
    const int64_t share = growth.shares[leaf];
    state.key = tree_.key(leaf);
    Cells cells = share > 0 ? directions_.take(state.root) : DirectionTrees::one_cell();
    DirectionTrees::estimate(cells, params_.direction.shrinkage);
    if (share != kShareOne)
      for (DirectionTrees::Cell& c : cells)
        c.joined = false;  // the halves may differ where they did not
    const size_t before = DirectionTrees::bytes_of(cells);
    const bool may_grow = 4 * before <= room;  // each leaf into four: less than 5 times as much
    if (may_grow || share == 0) DirectionTrees::adapt(cells, params_.direction);
    if (may_grow) room = room + before - DirectionTrees::bytes_of(cells);
    DirectionTrees::scale(cells, DirectionTrees::scaled(keep, share, kShareOne), kShareOne);
    put(state, std::move(cells), next);
    sums_[leaf].scale(keep, kShareOne);
    held_back += !may_grow;
  }
  directions_ = std::move(next);
  index();
  return held_back;
}

void AdaptiveGuide::index() {
  directions_.shrink();
  states_.shrink_to_fit();
  sums_.shrink_to_fit();
  tree_.index_within(max_bytes_, bytes() - tree_.bytes());
}

void AdaptiveGuide::doubt() {
  constexpr int64_t kDoubt = 16;
  rebuild(whole_trees(), kShareOne / kDoubt);
  samples_seen_ = samples_seen_ / kDoubt;
  seen_before_pass_ = samples_seen_;
  worth_ = {};
}

}  // namespace qray
