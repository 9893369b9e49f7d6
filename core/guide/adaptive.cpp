#include "core/guide/adaptive.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/math/warp.h"

namespace qray {
namespace {

constexpr size_t kLightsShare = 8;    // of the memory, that what is learned of lights may take
constexpr float kMaxInversePdf = 64;  // of the cosine density over the one drawn from
constexpr float kLeastCosine2 = 1e-9f;

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

WideFrame frame_of(const WideVec3& n, const SpatialTree::WideFace& face) {
  const auto turned = [&](const WideVec3& v) {
    return select(face.along_x, {v.z, v.x, v.y}, select(face.along_y, {v.y, v.z, v.x}, v));
  };
  WideFrame f(select(face.along_x, {n.y, n.z, n.x}, select(face.along_y, {n.z, n.x, n.y}, n)));
  f.x = turned(f.x);
  f.y = turned(f.y);
  f.z = n;
  return f;
}

WideFrame frames_of(const GuidePoints& points) {
  Vec3Lanes x, y, z;
  for (int i = 0; i < kWidth; ++i) {
    const Frame& frame = points[static_cast<size_t>(i)].frame;
    x.set(i, frame.x);
    y.set(i, frame.y);
    z.set(i, frame.z);
  }
  return {x.wide(), y.wide(), z.wide()};
}

}  // namespace

AdaptiveGuide::AdaptiveGuide(const GuideSetup& setup)
    : params_(setup.adaptive),
      max_bytes_(setup.max_bytes),
      radiance_unit_(std::exp2(std::ceil(std::log2(std::max(setup.brightest_light, 1e-30f))))),
      tree_(setup.bounds, SpatialTree::kFaces) {
  add_states();
  set_lights(setup.lights);
}

void AdaptiveGuide::set_lights(const LightClusters& clusters) {
  if (clusters == lights_.clusters()) return;
  const bool has_room = LightImportance::bytes_of(clusters) <= max_bytes_ / kLightsShare;
  lights_ = LightImportance(has_room ? clusters : LightClusters{});
}

AdaptiveGuide::AdaptiveGuide(const AdaptiveGuide& o)
    : params_(o.params_),
      max_bytes_(o.max_bytes_),
      radiance_unit_(o.radiance_unit_),
      tree_(o.tree_),
      states_(o.states_),
      sums_(o.sums_),
      known_(o.known_),
      directions_(o.directions_),
      lights_(o.lights_),
      samples_seen_(o.samples_seen_),
      refused_(o.refused_),
      worth_(o.worth_) {}

void AdaptiveGuide::add_states() {
  Cells cells = DirectionTrees::one_cell();
  DirectionTrees::adapt(cells, params_.direction);
  for (size_t leaf = states_.size(); leaf < tree_.leaves(); ++leaf) {
    State& state = states_.emplace_back();
    state.key = tree_.key(static_cast<uint32_t>(leaf));
    state.root = directions_.put(cells);
    sums_.emplace_back();
    known_.push_back(0);
  }
}

GuidePoint AdaptiveGuide::find(Vec3 p, Vec3 n) const {
  const int face = SpatialTree::face_of(n);
  const uint32_t leaf = tree_.leaf_at(tree_.beside(p, n), face);
  const State& state = states_[leaf];
  directions_.prefetch(state.root);
  return {StateId(leaf), state.key, frame_of(n, face)};
}

void AdaptiveGuide::find_each(const Vec3Lanes& p, const Vec3Lanes& n, uint32_t lanes,
                              GuidePoints& found) const {
  const WideVec3 normal = n.wide();
  const SpatialTree::WideFace face = SpatialTree::face_of(normal);
  SpatialTree::Searches searches;
  tree_.search_for(p.wide() + normal * wide(tree_.off_surface()), face, lanes, searches);
  uint32_t leaves[kWidth];
  for_each_lane(lanes, [&](int i) {
    SpatialTree::Search& search = searches[static_cast<size_t>(i)];
    while (tree_.go_down(search)) {
    }
    leaves[i] = search.leaf;
    __builtin_prefetch(&states_[search.leaf]);
  });
  const WideFrame frame = frame_of(normal, face);
  Vec3Lanes x, y;
  x = frame.x;
  y = frame.y;
  for_each_lane(lanes, [&](int i) {
    const State& state = states_[leaves[i]];
    directions_.prefetch(state.root);
    found[static_cast<size_t>(i)] = {StateId(leaves[i]), state.key, {x[i], y[i], n[i]}};
  });
}

// The base is the guide's alone: its density is a Lambert surface's at least. Lobes are their own,
// rough ones beside the guide.
GuideMixture AdaptiveGuide::mixture(const GuidePoint& point, const GuidedSurface& surface) const {
  const State& state = states_[point.state.value];
  if (!state.guides) return {};
  const bool fixed = params_.glossy >= 0;
  const float of_lobes = surface.smooth ? 0 : fixed ? params_.glossy : state.lobe_share;
  return GuideMixture::in_place_of_base(surface.base_chance, of_lobes);
}

GuideSample AdaptiveGuide::sample(const GuidePoint& point, Vec2 u) const {
  float density;
  const Vec2 square = directions_.sample(states_[point.state.value].root, u, density);
  const Vec2 d = square_to_disk(square);
  const float cos_theta = std::sqrt(std::max(kLeastCosine2, 1 - d.x * d.x - d.y * d.y));
  return {point.frame.to_world({d.x, d.y, cos_theta}), density * cos_theta * kInvPi};
}

float AdaptiveGuide::pdf_w(const GuidePoint& point, Vec3 wi) const {
  const Vec3 w = point.frame.to_local(wi);
  if (w.z <= 0) return 0;
  return directions_.pdf(states_[point.state.value].root, disk_to_square({w.x, w.y})) * w.z *
         kInvPi;
}

DirectionTrees::Roots AdaptiveGuide::roots_of(const GuidePoints& points, uint32_t lanes) const {
  DirectionTrees::Roots roots{};
  for_each_lane(lanes, [&](int i) {
    const auto k = static_cast<size_t>(i);
    roots[k] = states_[points[k].state.value].root;
  });
  return roots;
}

void AdaptiveGuide::sample_each(const GuidePoints& points, const Vec2Lanes& u, uint32_t lanes,
                                Vec3Lanes& wi, FloatLanes& pdf_w) const {
  Vec2Lanes square;
  directions_.sample_each(roots_of(points, lanes), u, lanes, square, pdf_w);
  const WideVec2 d = square_to_disk(square.x.wide(), square.y.wide());
  const Wide cos_theta = sqrt(max(wide(kLeastCosine2), 1 - d.x * d.x - d.y * d.y));
  wi = frames_of(points).to_world({d.x, d.y, cos_theta});
  pdf_w = pdf_w.wide() * cos_theta * kInvPi;
}

void AdaptiveGuide::pdf_w_each(const GuidePoints& points, const Vec3Lanes& wi, uint32_t lanes,
                               FloatLanes& pdf_w) const {
  const WideVec3 w = frames_of(points).to_local(wi.wide());
  const WideVec2 wide_square = disk_to_square(w.x, w.y);
  Vec2Lanes square;
  square.x = wide_square.x;
  square.y = wide_square.y;
  lanes &= lanes_of(w.z > 0);
  directions_.pdf_each(roots_of(points, lanes), square, lanes, pdf_w);
  pdf_w = mask_of(lanes) ? pdf_w.wide() * w.z * kInvPi : Wide{};
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

uint32_t AdaptiveGuide::expect_each(const GuidePoints& points, uint32_t lanes,
                                    ExpectationLanes& expected) const {
  uint32_t credible = 0;
  for_each_lane(lanes, [&](int i) {
    const State& state = states_[points[static_cast<size_t>(i)].state.value];
    expected.arriving.set(i, state.arriving);
    expected.deviation[i] = state.deviation;
    credible |= (state.credible ? 1u : 0u) << i;
  });
  return credible;
}

std::unique_ptr<GuideDelta> AdaptiveGuide::make_delta() const { return std::make_unique<Delta>(); }

void AdaptiveGuide::update(GuideDelta& delta) {
  samples_seen_ += std::exchange(static_cast<Delta&>(delta).samples, 0);
}

void AdaptiveGuide::record(std::span<const GuideVertex> path, GuideDelta& delta) const {
  for (const GuideVertex& v : path) {
    if (!v.guidable) continue;
    const State& state = states_[v.at.state.value];
    Sums& sums = sums_[v.at.state.value];
    LobeShares lobes;
    if (state.credible) lobes = LobeShares::of(v, luminance(state.arriving), state.deviation);
    const Vec3 w = v.at.frame.to_local(v.wi);
    if (w.z <= 0) {  // the guide never goes there, but lobes do
      const std::lock_guard guard(sums.lock);
      sums.lobes += lobes;
      continue;
    }
    const float inverse_pdf = std::min(w.z * kInvPi / v.pdf_w, kMaxInversePdf);
    const double factor = inverse_pdf / radiance_unit_;
    const double paid = luminance(v.arriving) * factor;
    if (!(paid < kMaxPaid)) continue;  // NaN too
    const bool upper = tree_.in_upper_half(tree_.beside(v.p, v.at.frame.z), v.at.state.value);
    ArrivalSums one = ArrivalSums::of(v.arriving, factor, paid, upper);
    one.lobes = lobes;
    const Vec2 u = disk_to_square({w.x, w.y});
    const std::lock_guard guard(sums.lock);
    sums += one;
    directions_.add(state.root, u, ArrivalSums::to_fixed(paid * ArrivalSums::kOne));
    ++static_cast<Delta&>(delta).samples;
  }
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
         sums_.capacity() * sizeof(Sums) + known_.capacity() * sizeof(int64_t) + tree_.bytes() +
         lights_.bytes();
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
  archive(self.tree_, self.states_, self.sums_, self.known_, self.directions_, self.lights_,
          self.samples_seen_, self.refused_, self.grows_, self.worth_.efficiency_gain,
          self.worth_.unguided_cost);
}

void AdaptiveGuide::save_state(SnapshotWriter& out) const { exchange_state(*this, out); }

void AdaptiveGuide::load_state(SnapshotReader& in) {
  exchange_state(*this, in);
  if (!lights_.fits()) in.fail();
}

}  // namespace qray
