#include "core/guide/adaptive.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr double kRadianceOne = 0x1p32;  // of radiance_unit_, in fixed point
constexpr double kSquareOne = 0x1p30, kSquareRest = 0x1p30;
constexpr double kMaxPaid = 1024;     // radiance units; a table may be clamped, a picture never
constexpr float kMaxInversePdf = 64;  // of the cosine density over the one drawn from
constexpr int64_t kMinSamples = 64;   // before a state is believed
constexpr float kGlossyFraction = 0.5f;
constexpr uint32_t kMaxLoadedDepth = 16;
constexpr size_t kMaxLoadedCells = 1 << 17;
constexpr int64_t kKeepOne = 256;  // the unit of what is kept

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
  n = o.n.load();
  for (int k = 0; k < 3; ++k) y[k] = o.y[k].load();
  square_hi = o.square_hi.load();
  square_lo = o.square_lo.load();
  return *this;
}

void AdaptiveGuide::Sums::scale(int64_t numerator, int64_t denominator) {
  for (std::atomic<int64_t>* v : {&n, &y[0], &y[1], &y[2], &square_hi, &square_lo})
    *v = DirectionTrees::scaled(*v, numerator, denominator);
}

AdaptiveGuide::AdaptiveGuide(const GuideSetup& setup)
    : params_(setup.adaptive),
      max_bytes_(setup.max_bytes),
      radiance_unit_(std::exp2(std::ceil(std::log2(std::max(setup.brightest_light, 1e-30f))))),
      tree_(setup.bounds) {
  faces_.push_back(no_states());
  seen_ = std::make_unique<std::atomic<bool>[]>(SpatialTree::kFaces);
}

GuidePoint AdaptiveGuide::find(Vec3 p, Vec3 n) const {
  const uint32_t leaf = tree_.leaf_at(p, n);
  const int face = SpatialTree::face_of(n);
  const uint32_t state = faces_[leaf][static_cast<size_t>(face)];
  const Frame frame = frame_of(n, face);
  if (state == kNoState)
    return {StateId(), uint64_t{leaf} * SpatialTree::kFaces + static_cast<uint64_t>(face), frame};
  return {StateId(state), states_[state].key, frame};
}

float AdaptiveGuide::guide_fraction(const GuidePoint& point, bool diffuse) const {
  if (!point.state.valid() || !states_[point.state.value].credible) return 0;
  return diffuse ? 1.0f : kGlossyFraction;
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
  if (!point.state.valid() || !states_[point.state.value].credible) return 1;
  return static_cast<float>(directions_.second_moment(states_[point.state.value].root));
}

GuideExpectation AdaptiveGuide::expectation(const GuidePoint& point) const {
  if (!point.state.valid()) return {};
  const State& state = states_[point.state.value];
  return {state.credible, state.arriving, state.deviation};
}

std::unique_ptr<GuideDelta> AdaptiveGuide::make_delta() const {
  return std::make_unique<GuideDelta>();
}

void AdaptiveGuide::record(std::span<const GuideVertex> path, GuideDelta&) const {
  for (const GuideVertex& v : path) {
    if (!v.at.state.valid()) {
      seen_[v.at.key].store(true, std::memory_order_relaxed);
      continue;
    }
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

// A place that was hit often becomes two, which share what it knew, and so on.
std::vector<int> AdaptiveGuide::cut_places() {
  std::vector<int> halvings(states_.size(), 0);
  for (uint32_t leaf = 0; leaf < faces_.size(); ++leaf) {
    if (tree_.nodes()[leaf].child != 0 || tree_.nodes()[leaf].depth >= SpatialTree::kMaxDepth)
      continue;
    double most = 0;
    for (uint32_t s : faces_[leaf])
      if (s != kNoState) most = std::max(most, value(sums_[s].n));
    if (most < params_.split_samples) continue;
    const uint32_t first = tree_.split(leaf);
    faces_.resize(first + 2, no_states());
    for (int face = 0; face < SpatialTree::kFaces; ++face) {
      const size_t f = static_cast<size_t>(face);
      const uint32_t s = faces_[leaf][f];
      if (s == kNoState) continue;
      sums_[s].scale(1, 2);
      ++halvings[s];
      faces_[first][f] = s;
      faces_[first + 1][f] = static_cast<uint32_t>(states_.size());
      states_[s].key = SpatialTree::key(tree_.nodes()[first], face);
      State other = states_[s];
      other.key = SpatialTree::key(tree_.nodes()[first + 1], face);
      states_.push_back(other);
      sums_.push_back(Sums(sums_[s]));
      halvings.push_back(int{halvings[s]});
    }
  }
  return halvings;
}

// Every tree is made anew, side by side in memory: from what was learned, cut finer where the data
// supports it, then faded.
void AdaptiveGuide::end_pass() {
  const int64_t keep = static_cast<int64_t>(params_.keep * static_cast<float>(kKeepOne));
  const bool may_grow = stats().bytes < max_bytes_ / 2;  // a pass at most doubles it, about
  // 1. States for places and faces that were seen for the first time.
  for (uint32_t leaf = 0; leaf < faces_.size(); ++leaf) {
    for (int face = 0; face < SpatialTree::kFaces; ++face) {
      const size_t f = static_cast<size_t>(face);
      if (!seen_[leaf * SpatialTree::kFaces + f] || faces_[leaf][f] != kNoState) continue;
      if (!may_grow) {
        ++refused_;
        continue;
      }
      faces_[leaf][f] = static_cast<uint32_t>(states_.size());
      states_.push_back({SpatialTree::key(tree_.nodes()[leaf], face), kNoState, {}, 0, false});
      sums_.emplace_back();
    }
  }
  // 2. Where they are. The means first: halves know as much as the whole.
  for (size_t s = 0; s < states_.size(); ++s) summarize(states_[s], sums_[s]);
  const std::vector<int> halvings = may_grow ? cut_places() : std::vector<int>(states_.size(), 0);
  // 3. Which way.
  DirectionTrees next;
  next.reserve(directions_.nodes());
  for (size_t s = 0; s < states_.size(); ++s) {
    State& state = states_[s];
    Cells cells =
        state.root == kNoState ? DirectionTrees::one_cell() : directions_.take(state.root);
    DirectionTrees::estimate(cells, params_.direction.shrinkage);
    if (may_grow) DirectionTrees::adapt(cells, params_.direction);
    DirectionTrees::scale(cells, keep, kKeepOne << halvings[s]);
    state.root = next.put(cells);
    sums_[s].scale(keep, kKeepOne);
  }
  directions_ = std::move(next);
  tree_.index_top();
  seen_ = std::make_unique<std::atomic<bool>[]>(faces_.size() * SpatialTree::kFaces);
}

GuideStats AdaptiveGuide::stats() const {
  const size_t bytes = directions_.bytes() + states_.capacity() * sizeof(State) +
                       sums_.capacity() * sizeof(Sums) +
                       faces_.capacity() * (sizeof(Faces) + SpatialTree::kFaces) + tree_.bytes();
  return {states_.size(), bytes, samples_seen_, refused_};
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
  std::vector<uint32_t> order(states_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return states_[a].key < states_[b].key; });
  ByteWriter out;
  out.u64(order.size());
  for (uint32_t s : order) {
    out.u64(states_[s].key);
    for (const auto* v : {&sums_[s].n, &sums_[s].y[0], &sums_[s].y[1], &sums_[s].y[2],
                          &sums_[s].square_hi, &sums_[s].square_lo})
      out.i64(*v);
    const Cells cells = directions_.take(states_[s].root);
    std::vector<uint32_t> open{0};
    while (!open.empty()) {
      const DirectionTrees::Cell& c = cells[open.back()];
      open.pop_back();
      out.u8(c.child != 0);
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

Status AdaptiveGuide::load_state(ByteReader& in) {
  const uint64_t key = in.u64();
  const int depth = std::bit_width(key >> 3) - 1;
  if (depth < 0 || depth > SpatialTree::kMaxDepth || (key & 7) >= SpatialTree::kFaces)
    return Error{ErrorCode::kCorrupt, "not a key of a place and a face", ""};
  if (!states_.empty() && key <= states_.back().key)
    return Error{ErrorCode::kCorrupt, "expected rising keys", ""};
  Sums sums;
  bool good = true;
  for (auto* v : {&sums.n, &sums.y[0], &sums.y[1], &sums.y[2], &sums.square_hi, &sums.square_lo}) {
    *v = in.i64();
    good = good && *v >= 0;
  }
  Cells cells = DirectionTrees::one_cell();
  std::vector<uint32_t> open{0};
  while (!open.empty() && in.ok()) {
    const uint32_t c = open.back();
    open.pop_back();
    const uint8_t cut = in.u8();
    good = good && cut <= 1 && (c != 0 || cut == 1);
    if (cut == 1) {
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
      DirectionTrees::Sums& sum = cells[c].sums;
      sum.s = in.i64();
      sum.n = in.u32();
      good = good && sum.s >= 0;
    }
  }
  if (!good || !in.ok())
    return Error{ErrorCode::kCorrupt, "expected sums >= 0 and whole trees", ""};
  const uint32_t node = tree_.reach(key >> 3);
  faces_.resize(tree_.nodes().size(), no_states());
  if (faces_[node][key & 7] != kNoState)
    return Error{ErrorCode::kCorrupt, "a key stands twice", ""};
  faces_[node][key & 7] = static_cast<uint32_t>(states_.size());
  DirectionTrees::estimate(cells, params_.direction.shrinkage);
  State state;
  state.key = key;
  state.root = directions_.put(cells);
  summarize(state, sums);
  states_.push_back(state);
  sums_.push_back(sums);
  return {};
}

Status AdaptiveGuide::load(std::span<const TableSection> sections) {
  QRAY_CHECK(states_.empty());
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
  if (exponent != tree_.cube_exponent() || !(origin == tree_.origin()) || unit != radiance_unit_)
    return Error{ErrorCode::kConflict, "the table's cube or unit is not this scene's",
                 "table:ACUB"};
  ByteReader in(sections[1].bytes);
  const uint64_t count = in.u64();
  Status status;
  uint64_t i = 0;
  for (; i < count && status.ok(); ++i) {
    status = load_state(in);
    if (status.ok() && stats().bytes > max_bytes_)
      status = Error{ErrorCode::kTooLarge,
                     "the table's " + std::to_string(count) + " states need more than the " +
                         std::to_string(max_bytes_) + " bytes allowed",
                     ""};
  }
  if (status.ok() && (!in.ok() || in.remaining() != 0))
    status = Error{ErrorCode::kCorrupt, "wrong size for " + std::to_string(count) + " states", ""};
  if (!status.ok()) {
    Error error = status.error();
    error.where = "table:AQTD" + (i > 0 ? ", state " + std::to_string(i - 1) : std::string());
    return error;
  }
  for (size_t node = 0; node < faces_.size(); ++node) {
    if (tree_.nodes()[node].child != 0 && faces_[node] != no_states())
      return Error{ErrorCode::kCorrupt, "places hold one another", "table:AQTD"};
  }
  samples_seen_ = samples_seen;
  tree_.index_top();
  seen_ = std::make_unique<std::atomic<bool>[]>(faces_.size() * SpatialTree::kFaces);
  return {};
}

}  // namespace qray
