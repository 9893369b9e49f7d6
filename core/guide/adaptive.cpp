#include "core/guide/adaptive.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/check.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr double kRadianceOne = 0x1p32;  // of radiance_unit_, in fixed point
constexpr double kSquareOne = 0x1p30, kSquareRest = 0x1p30;
constexpr double kMaxPaid = 1024;     // radiance units; a table may be clamped, a picture never
constexpr float kMaxInversePdf = 64;  // of the cosine density over the one drawn from
constexpr int64_t kMinSamples = 64;   // before a state is believed
constexpr uint32_t kMaxLoadedDepth = 16;
constexpr size_t kMaxLoadedCells = 1 << 17;
enum : uint8_t { kLeaf, kCut, kEven };  // a direction cell in a file
constexpr int64_t kShareOne = 1 << 16;  // the unit of shares and of what is kept

void add(std::atomic<int64_t>& sum, double v) {
  sum.fetch_add(static_cast<int64_t>(v), std::memory_order_relaxed);
}
double value(const std::atomic<int64_t>& sum) {
  return static_cast<double>(sum.load(std::memory_order_relaxed));
}

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

AdaptiveGuide::Sums& AdaptiveGuide::Sums::operator=(const Sums& o) {
  const auto from = const_cast<Sums&>(o).all(), to = all();
  for (size_t i = 0; i < to.size(); ++i) *to[i] = from[i]->load();
  return *this;
}

void AdaptiveGuide::Sums::scale(int64_t numerator, int64_t denominator) {
  for (std::atomic<int64_t>* v : all()) *v = DirectionTrees::scaled(*v, numerator, denominator);
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
      samples_seen_(o.samples_seen_.load()),
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
  if (!states_[point.state.value].credible) return 0;
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

GuideExpectation AdaptiveGuide::expectation(const GuidePoint& point) const {
  const State& state = states_[point.state.value];
  return {state.credible, state.arriving, state.deviation};
}

std::unique_ptr<GuideDelta> AdaptiveGuide::make_delta() const {
  return std::make_unique<GuideDelta>();
}

void AdaptiveGuide::record(std::span<const GuideVertex> path, GuideDelta&) const {
  for (const GuideVertex& v : path) {
    if (!v.guidable) continue;
    const Vec3 w = v.at.frame.to_local(v.wi);
    if (w.z <= 0) continue;
    const float inverse_pdf = std::min(w.z * kInvPi / v.pdf_w, kMaxInversePdf);
    const double factor = inverse_pdf / radiance_unit_;
    const double paid = luminance(v.arriving) * factor;
    if (!(paid < kMaxPaid)) continue;  // NaN too
    Sums& sums = sums_[v.at.state.value];
    for (int k = 0; k < 3; ++k) add(sums.y[k], v.arriving[k] * factor * kRadianceOne);
    const double square = paid * paid * kSquareOne, whole = std::floor(square);
    add(sums.square_hi, whole);
    add(sums.square_lo, (square - whole) * kSquareRest);
    sums.n.fetch_add(1, std::memory_order_relaxed);
    if (tree_.in_second_half(tree_.beside(v.p, v.at.frame.z), v.at.state.value))
      sums.second.fetch_add(1, std::memory_order_relaxed);
    directions_.add(states_[v.at.state.value].root, disk_to_square({w.x, w.y}),
                    static_cast<int64_t>(paid * kRadianceOne));
    samples_seen_.fetch_add(1, std::memory_order_relaxed);
  }
}

void AdaptiveGuide::summarize(State& state, const Sums& sums) const {
  const double n = value(sums.n);
  if (n < kMinSamples) return;
  Rgb y;
  for (int k = 0; k < 3; ++k) y[k] = static_cast<float>(value(sums.y[k]) / kRadianceOne / n);
  const double square =
      (value(sums.square_hi) + value(sums.square_lo) / kSquareRest) / kSquareOne / n;
  const double variance = std::max(0.0, square - sqr(luminance(y)));
  const float unit = static_cast<float>(radiance_unit_);
  state.arriving = y * unit;
  state.deviation = static_cast<float>(std::sqrt(variance)) * unit;
  state.credible = true;
}

// The halves share what the whole knew as they shared its samples.
void AdaptiveGuide::cut(uint32_t leaf, std::vector<int64_t>& shares) {
  const int64_t n = sums_[leaf].n, second = sums_[leaf].second;
  const int64_t part = n > 0 ? DirectionTrees::scaled(kShareOne, second, n) : 0;
  tree_.split(leaf);
  State half = states_[leaf];
  Sums sums = sums_[leaf];
  sums.scale(part, kShareOne);
  int64_t share = DirectionTrees::scaled(shares[leaf], part, kShareOne);
  const auto taken = sums.all(), left = sums_[leaf].all();
  for (size_t i = 0; i < left.size(); ++i) *left[i] -= *taken[i];
  shares[leaf] -= share;
  // Where in each half its samples lay is not known: on both sides alike.
  sums_[leaf].second = sums_[leaf].n / 2;
  sums.second = sums.n / 2;
  if (part == 0) half.credible = false;
  if (part == kShareOne) states_[leaf].credible = false;
  states_.push_back(half);
  sums_.push_back(sums);
  shares.push_back(share);
}

std::vector<int64_t> AdaptiveGuide::cut_places(size_t& room) {
  std::vector<int64_t> shares(states_.size(), kShareOne);
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    size_t half = 0;  // bytes
    while (value(sums_[leaf].n) > params_.split_samples &&
           tree_.depth(leaf) < SpatialTree::kMaxDepth) {
      if (half == 0)
        half = sizeof(State) + sizeof(Sums) + SpatialTree::kMaxLeafBytes +
               DirectionTrees::bytes_of(directions_.take(states_[leaf].root));
      if (half > room) {
        refused_ += grows_;
        break;
      }
      room -= half;
      cut(leaf, shares);
    }
  }
  return shares;
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
  size_t room = grows_ && most > taken ? most - taken : 0;
  // The means first: halves know as much as the whole.
  for (size_t s = 0; s < states_.size(); ++s) summarize(states_[s], sums_[s]);
  const std::vector<int64_t> shares = cut_places(room);
  const size_t held_back =
      rebuild(shares, static_cast<int64_t>(params_.keep * static_cast<float>(kShareOne)), room);
  if (grows_) refused_ += held_back;
}

size_t AdaptiveGuide::rebuild(const std::vector<int64_t>& shares, int64_t keep, size_t room) {
  DirectionTrees next;
  size_t held_back = 0;
  next.reserve(directions_.nodes());
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    State& state = states_[leaf];
    state.key = tree_.key(leaf);
    Cells cells = shares[leaf] > 0 ? directions_.take(state.root) : DirectionTrees::one_cell();
    DirectionTrees::estimate(cells, params_.direction.shrinkage);
    if (shares[leaf] != kShareOne)
      for (DirectionTrees::Cell& c : cells)
        c.even = false;  // the halves may differ where they did not
    const size_t before = DirectionTrees::bytes_of(cells);
    const bool may_grow = 4 * before <= room;  // each leaf into four: less than 5 times as much
    if (may_grow || shares[leaf] == 0) DirectionTrees::adapt(cells, params_.direction);
    if (may_grow) room = room + before - DirectionTrees::bytes_of(cells);
    DirectionTrees::scale(cells, DirectionTrees::scaled(keep, shares[leaf], kShareOne), kShareOne);
    state.root = next.put(cells);
    sums_[leaf].scale(keep, kShareOne);
    held_back += !may_grow;
  }
  directions_ = std::move(next);
  index();
  return held_back;
}

// The index over places takes what is left.
void AdaptiveGuide::index() {
  directions_.shrink();
  states_.shrink_to_fit();
  sums_.shrink_to_fit();
  tree_.index_top(0);
  const size_t taken = bytes();
  if (taken < max_bytes_) tree_.index_top(max_bytes_ - taken);
}

// Cuts wherever the other table did.
void AdaptiveGuide::refine_as(const AdaptiveGuide& other) {
  std::vector<int64_t> shares(states_.size(), kShareOne);
  for (const State& o : other.states_) {
    const auto leaf_of = [&] { return tree_.leaf_with(o.key); };
    for (uint32_t leaf = leaf_of(); leaf != SpatialTree::kNone && states_[leaf].key != o.key;
         leaf = leaf_of()) {
      cut(leaf, shares);
      for (const size_t half : {size_t{leaf}, states_.size() - 1})
        states_[half].key = tree_.key(static_cast<uint32_t>(half));
    }
  }
  rebuild(shares, kShareOne, 0);
}

void AdaptiveGuide::doubt() {
  constexpr int64_t kDoubt = 16;
  rebuild(std::vector<int64_t>(states_.size(), kShareOne), kShareOne / kDoubt, 0);
  samples_seen_ = samples_seen_ / kDoubt;
}

Status AdaptiveGuide::merge(const Guide& other) {
  const auto* table = dynamic_cast<const AdaptiveGuide*>(&other);
  if (!table) return Guide::merge(other);
  if (table->tree_.cube_exponent() != tree_.cube_exponent() ||
      !(table->tree_.origin() == tree_.origin()) || table->radiance_unit_ != radiance_unit_)
    return Error{ErrorCode::kConflict, "the tables' cubes or units differ", "table"};
  AdaptiveGuide from(*table), to(*this);
  from.refine_as(to);
  to.refine_as(from);
  DirectionTrees next;
  for (uint32_t leaf = 0; leaf < to.states_.size(); ++leaf) {
    const uint32_t same = from.tree_.leaf_with(to.states_[leaf].key);
    const auto sums = to.sums_[leaf].all(), add = from.sums_[same].all();
    for (size_t i = 0; i < sums.size(); ++i) *sums[i] += *add[i];
    Cells cells = to.directions_.take(to.states_[leaf].root);
    DirectionTrees::add_cells(cells, from.directions_.take(from.states_[same].root));
    DirectionTrees::estimate(cells, params_.direction.shrinkage);
    const uint64_t key = to.states_[leaf].key;
    to.states_[leaf] = {};  // as load() would
    to.states_[leaf].key = key;
    to.states_[leaf].root = next.put(cells);
    to.summarize(to.states_[leaf], to.sums_[leaf]);
  }
  to.directions_ = std::move(next);
  to.index();
  if (to.bytes() > max_bytes_)
    return Error{ErrorCode::kTooLarge,
                 "both tables need more than the " + std::to_string(max_bytes_) + " bytes allowed",
                 "table"};
  tree_ = std::move(to.tree_);
  states_ = std::move(to.states_);
  sums_ = std::move(to.sums_);
  directions_ = std::move(to.directions_);
  samples_seen_ += table->samples_seen_;
  return {};
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

// Sections: ACUB (the cube, the unit, the samples seen), AQTD (a record per state, keys rising:
// key, sums, then the direction cells depth first: a byte, 1 for one that is cut, and a leaf's
// sums).
std::vector<TableSection> AdaptiveGuide::save() const {
  ByteWriter cube;
  cube.i64(tree_.cube_exponent());
  for (int axis = 0; axis < 3; ++axis) cube.f32(tree_.origin()[axis]);
  cube.f64(radiance_unit_);
  cube.u64(samples_seen_);
  std::vector<uint32_t> order;
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf)
    if (sums_[leaf].n > 0) order.push_back(leaf);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return states_[a].key < states_[b].key; });
  ByteWriter out;
  out.u64(order.size());
  for (uint32_t s : order) {
    out.u64(states_[s].key);
    for (const auto* v : sums_[s].all()) out.i64(*v);
    const Cells cells = directions_.take(states_[s].root);
    std::vector<uint32_t> open{0};
    while (!open.empty()) {
      const DirectionTrees::Cell& c = cells[open.back()];
      open.pop_back();
      out.u8(c.child != 0 ? kCut : c.even ? kEven : kLeaf);
      if (c.child != 0) {
        for (uint32_t q = 4; q-- > 0;) open.push_back(c.child + q);
      } else {
        out.i64(c.sums.s);
        out.u32(c.sums.n);
      }
    }
  }
  return {{"ACUB", cube.take()}, {"AQTD", out.take()}};
}

Status AdaptiveGuide::load_state(ByteReader& in, uint64_t& last_key) {
  const uint64_t key = in.u64();
  if (!SpatialTree::valid_key(key, SpatialTree::kFaces))
    return Error{ErrorCode::kCorrupt, "not a key of a place and a face", ""};
  if (key <= last_key) return Error{ErrorCode::kCorrupt, "expected rising keys", ""};
  last_key = key;
  Sums sums;
  bool good = true;
  for (auto* v : sums.all()) {
    *v = in.i64();
    good = good && *v >= 0;
  }
  good = good && sums.n > 0 && sums.second <= sums.n;
  Cells cells = DirectionTrees::one_cell();
  std::vector<uint32_t> open{0};
  while (!open.empty() && in.ok()) {
    const uint32_t c = open.back();
    open.pop_back();
    const uint8_t cut = in.u8();
    good = good && cut <= kEven && (c != 0 || cut == kCut);
    if (cut == kCut) {
      const uint32_t depth_below = cells[c].depth + 1;
      if (depth_below > kMaxLoadedDepth || cells.size() > kMaxLoadedCells) good = false;
      if (!good) break;
      cells[c].child = static_cast<uint32_t>(cells.size());
      cells.resize(cells.size() + 4);
      for (uint32_t q = 4; q-- > 0;) {
        cells[cells[c].child + q].depth = depth_below;
        open.push_back(cells[c].child + q);
      }
    } else {
      cells[c].even = cut == kEven;
      DirectionTrees::Sums& sum = cells[c].sums;
      sum.s = in.i64();
      sum.n = in.u32();
      good = good && sum.s >= 0;
    }
  }
  if (!good || !in.ok())
    return Error{ErrorCode::kCorrupt, "expected sums >= 0 and whole trees", ""};
  const uint32_t leaf = tree_.reach(key);
  add_states();
  if (leaf == SpatialTree::kNone || sums_[leaf].n > 0)
    return Error{ErrorCode::kCorrupt, "places stand twice or hold one another", ""};
  DirectionTrees::estimate(cells, params_.direction.shrinkage);
  states_[leaf].key = key;
  states_[leaf].root = directions_.put(cells);
  summarize(states_[leaf], sums);
  sums_[leaf] = sums;
  return {};
}

Status AdaptiveGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(samples_seen_ == 0);
  if (sections.size() != 2 || sections[0].tag != "ACUB" || sections[1].tag != "AQTD")
    return Error{ErrorCode::kCorrupt, "expected the sections ACUB and AQTD", "table"};
  ByteReader cube(sections[0].bytes);
  const int64_t exponent = cube.i64();
  Vec3 origin;
  for (int axis = 0; axis < 3; ++axis) origin[axis] = cube.f32();
  const double unit = cube.f64();
  const uint64_t samples_seen = cube.u64();
  if (!cube.ok() || cube.remaining() != 0)
    return Error{ErrorCode::kCorrupt, "wrong size", "table:ACUB"};
  if (exponent != tree_.cube_exponent() || !(origin == tree_.origin()))
    return Error{ErrorCode::kConflict, "the table's cube is not this scene's", "table:ACUB"};
  if (!(unit > 0) || !std::isfinite(unit))
    return Error{ErrorCode::kCorrupt, "expected a unit of radiance over 0", "table:ACUB"};
  radiance_unit_ = unit;  // it goes on with the table's, should lights have changed
  ByteReader in(sections[1].bytes);
  const uint64_t count = in.u64();
  const Error too_large{ErrorCode::kTooLarge,
                        "the table's " + std::to_string(count) + " states need more than the " +
                            std::to_string(max_bytes_) + " bytes allowed",
                        "table:AQTD"};
  Status status;
  uint64_t i = 0, last_key = 0;
  for (; i < count && status.ok(); ++i) {
    status = load_state(in, last_key);
    if (status.ok() && bytes() / 2 > max_bytes_) status = too_large;  // with what load leaves over
  }
  if (status.ok() && (!in.ok() || in.remaining() != 0))
    status = Error{ErrorCode::kCorrupt, "wrong size for " + std::to_string(count) + " states", ""};
  if (!status.ok()) {
    Error error = status.error();
    error.where = "table:AQTD" + (i > 0 ? ", state " + std::to_string(i - 1) : std::string());
    return error;
  }
  for (uint32_t leaf = 0; leaf < states_.size(); ++leaf) {
    const uint64_t key = tree_.key(leaf);
    if (sums_[leaf].n > 0 && states_[leaf].key != key)  // cut after it was loaded
      return Error{ErrorCode::kCorrupt, "places hold one another", "table:AQTD"};
    states_[leaf].key = key;
  }
  rebuild(std::vector<int64_t>(states_.size(), kShareOne), kShareOne, 0);
  if (count > 0 && bytes() > max_bytes_) return too_large;
  samples_seen_ = samples_seen;
  return {};
}

}  // namespace qray
