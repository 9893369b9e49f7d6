#include "core/guide/adaptive.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/math/warp.h"

namespace qray {
namespace {

constexpr double kRadianceOne = 0x1p32;  // of radiance_unit_, in fixed point
constexpr double kSquareOne = 0x1p30, kSquareRest = 0x1p30;
constexpr double kMaxPaid = 1024;     // radiance units; a table may be clamped, a picture never
constexpr float kMaxInversePdf = 64;  // of the cosine density over the one drawn from
constexpr int64_t kMinSamples = 64;   // before a state is believed

double to_double(int64_t v) { return static_cast<double>(v); }
int64_t to_fixed(double v) { return static_cast<int64_t>(v); }

// A frame about n that turns smoothly with it for all n of a face: Frame's own turns over where n.z
// changes its sign, so axes are exchanged to have the face's first.
Frame frame_of(Vec3 n, int face) {
  const auto turned = [](Vec3 v, int axis) {
    return axis == 0 ? Vec3{v.z, v.x, v.y} : axis == 1 ? Vec3{v.y, v.z, v.x} : v;
  };
  const int axis = face / 2;
  const Frame f(axis == 0 ? Vec3{n.y, n.z, n.x} : axis == 1 ? Vec3{n.z, n.x, n.y} : n);
  return {turned(f.x, axis), turned(f.y, axis), n};
}

}  // namespace

void AdaptiveGuide::Sums::scale(int64_t numerator, int64_t denominator) {
  for (int64_t* v : all()) *v = DirectionTrees::scaled(*v, numerator, denominator);
}

AdaptiveGuide::AdaptiveGuide(const GuideSetup& setup)
    : params_(setup.adaptive),
      max_bytes_(setup.max_bytes),
      radiance_unit_(std::exp2(std::ceil(std::log2(std::max(setup.brightest_light, 1e-30f))))),
      tree_(setup.bounds, SpatialTree::kFaces) {
  add_states();
}

AdaptiveGuide::AdaptiveGuide(const AdaptiveGuide& o)
    : params_(o.params_),
      max_bytes_(o.max_bytes_),
      radiance_unit_(o.radiance_unit_),
      tree_(o.tree_),
      states_(o.states_),
      sums_(o.sums_),
      directions_(o.directions_),
      samples_seen_(o.samples_seen_),
      refused_(o.refused_) {}

void AdaptiveGuide::add_states() {
  Cells cells = DirectionTrees::one_cell();
  DirectionTrees::adapt(cells, params_.direction);
  for (size_t leaf = states_.size(); leaf < tree_.leaves(); ++leaf) {
    State& state = states_.emplace_back();
    state.key = tree_.key(static_cast<uint32_t>(leaf));
    state.root = directions_.put(cells);
    sums_.emplace_back();
  }
}

GuidePoint AdaptiveGuide::find(Vec3 p, Vec3 n) const {
  const int face = SpatialTree::face_of(n);
  const uint32_t leaf = tree_.leaf_at(tree_.beside(p, n), face);
  const State& state = states_[leaf];
  directions_.prefetch(state.root);
  return {StateId(leaf), state.key, frame_of(n, face)};
}

float AdaptiveGuide::guide_fraction(const GuidePoint& point, bool diffuse) const {
  if (!states_[point.state.value].guides) return 0;
  return diffuse ? 1.0f : params_.glossy;
}

GuideSample AdaptiveGuide::sample(const GuidePoint& point, Vec2 u) const {
  float density;
  const Vec2 square = directions_.sample(states_[point.state.value].root, u, density);
  const Vec2 d = square_to_disk(square);
  const float cos_theta = std::sqrt(std::max(1e-9f, 1 - d.x * d.x - d.y * d.y));
  return {point.frame.to_world({d.x, d.y, cos_theta}), density * cos_theta * kInvPi};
}

float AdaptiveGuide::pdf_w(const GuidePoint& point, Vec3 wi) const {
  const Vec3 w = point.frame.to_local(wi);
  if (w.z <= 0) return 0;
  return directions_.pdf(states_[point.state.value].root, disk_to_square({w.x, w.y})) * w.z *
         kInvPi;
}

float AdaptiveGuide::gain(const GuidePoint& point) const {
  if (!states_[point.state.value].credible) return 1;
  return static_cast<float>(directions_.second_moment(states_[point.state.value].root));
}

std::vector<DirectionCell> AdaptiveGuide::directions(const GuidePoint& point) const {
  std::vector<DirectionCell> cells;
  const Cells tree = directions_.take(states_[point.state.value].root);
  for (const DirectionTrees::Leaf& leaf : DirectionTrees::leaves(tree)) {
    const Vec2 middle = leaf.corner + Vec2{leaf.size / 2, leaf.size / 2};
    const Vec3 local = square_to_cosine_hemisphere(middle);
    cells.push_back({point.frame.to_world(local), static_cast<float>(leaf.mean) * local.z * kInvPi,
                     leaf.corner, leaf.size});
  }
  return cells;
}

StateSummary AdaptiveGuide::summary(const GuidePoint& point) const {
  return {max_component(tree_.extent(point.state.value)),
          static_cast<uint64_t>(sums_[point.state.value].n)};
}

GuideExpectation AdaptiveGuide::expectation(const GuidePoint& point) const {
  const State& state = states_[point.state.value];
  return {state.credible, state.arriving, state.deviation};
}

std::unique_ptr<GuideDelta> AdaptiveGuide::make_delta() const { return std::make_unique<Delta>(); }

void AdaptiveGuide::update(GuideDelta& delta) {
  samples_seen_ += std::exchange(static_cast<Delta&>(delta).samples, 0);
}

void AdaptiveGuide::record(std::span<const GuideVertex> path, GuideDelta& delta) const {
  for (const GuideVertex& v : path) {
    if (!v.guidable) continue;
    const Vec3 w = v.at.frame.to_local(v.wi);
    if (w.z <= 0) continue;
    const float inverse_pdf = std::min(w.z * kInvPi / v.pdf_w, kMaxInversePdf);
    const double factor = inverse_pdf / radiance_unit_;
    const double paid = luminance(v.arriving) * factor;
    if (!(paid < kMaxPaid)) continue;  // NaN too
    const double square = paid * paid * kSquareOne, whole = std::floor(square);
    const bool upper = tree_.in_upper_half(tree_.beside(v.p, v.at.frame.z), v.at.state.value);
    const Vec2 u = disk_to_square({w.x, w.y});
    Sums& sums = sums_[v.at.state.value];
    const std::lock_guard guard(sums.lock);
    ++sums.n;
    sums.n_upper += upper;
    for (int k = 0; k < 3; ++k) sums.y[k] += to_fixed(v.arriving[k] * factor * kRadianceOne);
    sums.square_hi += to_fixed(whole);
    sums.square_lo += to_fixed((square - whole) * kSquareRest);
    directions_.add(states_[v.at.state.value].root, u, to_fixed(paid * kRadianceOne));
    ++static_cast<Delta&>(delta).samples;
  }
}

void AdaptiveGuide::summarize(State& state, const Sums& sums) const {
  const double n = to_double(sums.n);
  if (n < kMinSamples) return;
  Rgb y;
  for (int k = 0; k < 3; ++k) y[k] = static_cast<float>(to_double(sums.y[k]) / kRadianceOne / n);
  const double square =
      (to_double(sums.square_hi) + to_double(sums.square_lo) / kSquareRest) / kSquareOne / n;
  const double variance = std::max(0.0, square - sqr(luminance(y)));
  const float unit = static_cast<float>(radiance_unit_);
  state.arriving = y * unit;
  state.deviation = static_cast<float>(std::sqrt(variance)) * unit;
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
  int64_t share = DirectionTrees::scaled(shares[leaf], part, kShareOne);
  const auto taken = sums.all(), left = sums_[leaf].all();
  for (size_t i = 0; i < left.size(); ++i) *left[i] -= *taken[i];
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
    while (to_double(sums_[leaf].n) > params_.split_samples &&
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
  const int64_t keep = static_cast<int64_t>(params_.keep * static_cast<float>(kShareOne));
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
}

std::vector<GuidePoint> AdaptiveGuide::known_points(size_t most) const {
  std::vector<GuidePoint> points;
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    if (!states_[leaf].credible) continue;
    const int face = static_cast<int>(states_[leaf].key & 7);
    Vec3 n;
    n[face / 2] = face % 2 == 0 ? 1.0f : -1.0f;
    points.push_back({StateId(leaf), states_[leaf].key, frame_of(n, face)});
  }
  return spread_over(std::move(points), most);
}

size_t AdaptiveGuide::bytes() const {
  return directions_.bytes() + states_.capacity() * sizeof(State) +
         sums_.capacity() * sizeof(Sums) + tree_.bytes();
}

// Leaves that nothing hit are no states, and their memory is the tree's; a tree without states is
// no table.
GuideStats AdaptiveGuide::stats() const {
  const auto known =
      std::count_if(sums_.begin(), sums_.end(), [](const Sums& s) { return s.n > 0; });
  return {static_cast<size_t>(known), directions_.nodes(), known > 0 ? bytes() : 0, samples_seen_,
          refused_};
}

template <class Self, class Archive>
void AdaptiveGuide::exchange_state(Self& self, Archive& archive) {
  archive(self.tree_, self.states_, self.sums_, self.directions_, self.samples_seen_, self.refused_,
          self.grows_);
}

void AdaptiveGuide::save_state(SnapshotWriter& out) const { exchange_state(*this, out); }

void AdaptiveGuide::load_state(SnapshotReader& in) { exchange_state(*this, in); }

}  // namespace qray
