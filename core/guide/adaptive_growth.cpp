// How AdaptiveGuide's places and directions grow between passes, within its memory.
#include <algorithm>
#include <utility>

#include "core/guide/adaptive.h"

namespace qray {
namespace {

constexpr int64_t kMinSamples = 64;  // before a state is believed
constexpr int64_t kNews = 16;  // a pass that brings less than that part of what is known waits
constexpr double kMostSamples = 0x1p30;  // of a state: its directions count with 32 bits

}  // namespace

void AdaptiveGuide::summarize(State& state, const Sums& sums) const {
  if (sums.n < kMinSamples) return;
  const float unit = static_cast<float>(radiance_unit_);
  state.arriving = sums.mean() * unit;
  state.deviation = static_cast<float>(sums.deviation()) * unit;
  state.credible = true;
}

// Samples below the surface count in no n, but they are few: the means are usual ones, no more.
void AdaptiveGuide::choose_lobe_shares() {
  LobeShares::Means usual{};
  double n = 0;
  for (const Sums& sums : sums_) {
    n += static_cast<double>(sums.n);
    for (size_t i = 0; i < usual.size(); ++i)
      usual[i] += static_cast<double>(sums.lobes.moments[i]);
  }
  if (!(n > 0)) return;
  for (double& mean : usual) mean /= n;
  for (size_t s = 0; s < states_.size(); ++s) states_[s].lobe_share = sums_[s].lobes.best(usual);
}

// The halves share what the whole knew as they shared its samples.
void AdaptiveGuide::cut(uint32_t leaf, Growth& growth) {
  const int64_t n = sums_[leaf].n;
  const int64_t part = n > 0 ? DirectionTrees::scaled(kShareOne, sums_[leaf].n_upper, n) : 0;
  tree_.split(leaf);
  State half = states_[leaf];
  Sums sums = sums_[leaf];
  sums.scale(part, kShareOne);
  sums_[leaf] -= sums;
  Growth::Part half_of = growth.parts[leaf];
  half_of.share = DirectionTrees::scaled(half_of.share, part, kShareOne);
  growth.parts[leaf].share -= half_of.share;
  // Where in each half its samples lay is not known: on both sides alike.
  sums_[leaf].n_upper = sums_[leaf].n / 2;
  sums.n_upper = sums.n / 2;
  if (part == 0) half.credible = false;
  if (part == kShareOne) states_[leaf].credible = false;
  states_.push_back(half);
  sums_.push_back(sums);
  known_.push_back(0);
  growth.parts.push_back(half_of);
}

// Gives the state, of which it is known whether it is credible, its directions.
void AdaptiveGuide::put(State& state, Cells cells, DirectionTrees& to) const {
  DirectionTrees::add_uniform(cells, params_.uniform);
  state.root = to.put(cells);
  state.guides = state.credible && to.second_moment(state.root) >= params_.min_gain;
}

AdaptiveGuide::Growth AdaptiveGuide::whole_trees(int64_t keep) const {
  return {std::vector<Growth::Part>(states_.size(), {.keep = keep})};
}

// What a pass brings to a place displaces what was known there, since it was guided better, as far
// as it is much against it: with f the pass' part of the sums, 1 - f^2 / (1 - keep) are kept, and
// `keep` at least. So the sums never come to hold fewer samples, and where a pass saw nothing
// nothing is forgotten.
int64_t AdaptiveGuide::kept(size_t state) const {
  const auto all = static_cast<double>(sums_[state].n);
  const double f = (all - static_cast<double>(known_[state])) / all;
  const double most = 1 - static_cast<double>(params_.keep);
  double keep = f < most ? 1 - f * f / most : 1 - most;
  keep = std::min(keep, kMostSamples / all);
  return static_cast<int64_t>(std::ceil(keep * static_cast<double>(kShareOne)));
}

AdaptiveGuide::Growth AdaptiveGuide::news() const {
  Growth growth = whole_trees();
  for (size_t s = 0; s < states_.size(); ++s) {
    const int64_t brought = sums_[s].n - known_[s];
    growth.parts[s].stays = sums_[s].n < kMinSamples || brought < known_[s] / kNews;
    if (!growth.parts[s].stays) growth.parts[s].keep = kept(s);
  }
  return growth;
}

void AdaptiveGuide::cut_places(Growth& growth) {
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    if (growth.parts[leaf].stays) continue;
    size_t half = 0;  // bytes
    while (static_cast<double>(sums_[leaf].n) > params_.split_samples &&
           tree_.depth(leaf) < SpatialTree::kMaxDepth) {
      if (half == 0)
        half = sizeof(State) + sizeof(Sums) + sizeof(int64_t) + SpatialTree::kMaxLeafBytes +
               DirectionTrees::bytes_of(directions_.take(states_[leaf].root));
      if (half > growth.room) {
        refused_ += grows_;
        break;
      }
      growth.room -= half;
      cut(leaf, growth);
    }
  }
}

// The trees are made anew, side by side in memory: from what was learned, cut finer where the data
// supports it and there is room, then faded.
void AdaptiveGuide::end_pass() {
  lights_.end_pass();
  // An eighth is left for the index over places.
  tree_.index_top(0);
  const size_t most = max_bytes_ - max_bytes_ / 8, taken = bytes();
  if (taken > max_bytes_) {  // not even for the places to begin with
    for (Sums& sums : sums_) sums.scale(0, 1);
    ++refused_;
    return;
  }
  Growth growth = news();
  growth.room = grows_ && most > taken ? most - taken : 0;
  // The means first: halves know as much as the whole.
  for (size_t s = 0; s < states_.size(); ++s)
    if (!growth.parts[s].stays) summarize(states_[s], sums_[s]);
  cut_places(growth);
  choose_lobe_shares();
  const size_t held_back = rebuild(growth);
  if (grows_) refused_ += held_back;
}

size_t AdaptiveGuide::rebuild(const Growth& growth) {
  size_t room = growth.room;
  DirectionTrees next;
  size_t held_back = 0;
  next.reserve(directions_.nodes());
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    State& state = states_[leaf];
    const auto& [share, keep, stays] = growth.parts[leaf];
    if (stays) {
      state.root = next.put_tree(directions_, state.root);
      continue;
    }
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
    known_[leaf] = sums_[leaf].n;
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
  known_.shrink_to_fit();
  tree_.index_within(max_bytes_, bytes() - tree_.bytes());
}

void AdaptiveGuide::fade(int times) {
  rebuild(whole_trees(kShareOne / times));
  lights_.fade(times);
  samples_seen_ = samples_seen_ / static_cast<uint64_t>(times);
}

void AdaptiveGuide::doubt() {
  constexpr int kDoubt = 16;
  fade(kDoubt);
  worth_ = {};
}

}  // namespace qray
