#include "core/guide/adaptive.h"

#include <gtest/gtest.h>

#include <set>

#include "core/base/byte_io.h"
#include "core/math/warp.h"
#include "tests/support/random.h"

namespace qray {
namespace {

GuideSetup setup_with(size_t max_bytes = kDefaultTableBytes) {
  GuideSetup setup;
  setup.bounds = {{0, 0, 0}, {4, 2, 3}};
  setup.brightest_light = 50;
  setup.max_bytes = max_bytes;
  setup.adaptive.split_samples = 2000;
  setup.adaptive.direction.split_share = 0.01f;
  setup.adaptive.direction.min_split_gain = -1;
  setup.adaptive.min_gain = 0;
  return setup;
}

// Random events on the floor and, `of_wall` of them, a wall, more of them and brighter at x = 3;
// every `shuffle`-th event first where that is over 1. `narrow`: from near the normal alone.
void teach(AdaptiveGuide& guide, uint64_t seed, int events, int shuffle = 1, bool narrow = false,
           float of_wall = 0.3f) {
  test::Random random(seed);
  std::vector<GuideVertex> all;
  for (int i = 0; i < events; ++i) {
    GuideVertex v;
    const bool wall = random.next() < of_wall;
    const float x = 4 * std::sqrt(random.next());
    const Vec3 n = wall ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    v.p = {x, wall ? 2 * random.next() : 0, wall ? 0 : 3 * random.next()};
    v.at = guide.find(v.p, n);
    const Vec3 local = square_to_cosine_hemisphere(random.next_2d());
    v.wi = v.at.frame.to_world(local);
    v.pdf_w = cosine_hemisphere_pdf_w(local.z);
    v.bsdf.f_cos = 0.5f * v.pdf_w;  // a lobe as broad as a Lambert surface's
    v.bsdf.pdf_w = v.pdf_w;
    v.bsdf.guide_pdf_w = guide.pdf_w(v.at, v.wi);
    v.bsdf.surface.base_chance = 0;
    v.guidable = true;
    v.arriving = Rgb{x > 3 ? 20.0f : 1.0f} * random.next();
    if (narrow && local.x * local.x + local.y * local.y > 0.1f) v.arriving = {};
    all.push_back(v);
  }
  const std::unique_ptr<GuideDelta> delta = guide.make_delta();
  for (int first = 0; first < shuffle; ++first)
    for (size_t i = static_cast<size_t>(first); i < all.size(); i += static_cast<size_t>(shuffle))
      guide.record({&all[i], 1}, *delta);
  guide.update(*delta);
  guide.end_pass();
}

Bytes bytes_of(const Guide& guide) {
  TableFile file;
  file.sections = guide.save();
  return encode_table(file);
}

std::unique_ptr<AdaptiveGuide> taught(int passes, int shuffle = 1) {
  auto guide = std::make_unique<AdaptiveGuide>(setup_with());
  for (int pass = 0; pass < passes; ++pass)
    teach(*guide, static_cast<uint64_t>(pass), 20000, shuffle);
  return guide;
}

TEST(Adaptive, UntaughtItGuidesNowhere) {
  const AdaptiveGuide guide(setup_with());
  const GuidePoint point = guide.find({1, 0, 1}, {0, 1, 0});
  EXPECT_EQ(guide.mixture(point, {}).guide, 0);
  EXPECT_FALSE(guide.expectation(point).credible);
  EXPECT_EQ(guide.stats().states, 0u);
  EXPECT_TRUE(guide.known_points(10).empty());
}

TEST(Adaptive, PlacesThatAreHitOftenAreCutFiner) {
  const auto guide = taught(12);
  const auto at = [&](float x) { return guide->find({x, 0, 1}, {0, 1, 0}); };
  EXPECT_EQ(guide->mixture(at(3.5f), {}).guide, 1);
  EXPECT_NEAR(guide->expectation(at(3.7f)).arriving.g, 10, 2);
  EXPECT_NEAR(guide->expectation(at(2.2f)).arriving.g, 0.5f, 0.25f);
  EXPECT_NE(at(3.7f).state, at(2.2f).state);
  const GuidePoint below = guide->find({1, 0, 1}, {0, -1, 0});  // a side that nothing hit
  EXPECT_EQ(guide->mixture(below, {}).guide, 0);
  EXPECT_FALSE(guide->expectation(below).credible);
  EXPECT_GT(guide->stats().states, 20u);
  EXPECT_EQ(guide->stats().samples_seen, 12u * 20000);
}

TEST(Adaptive, AnswersForSeveralPointsAsForOne) {
  AdaptiveGuide guide(setup_with());
  for (uint64_t pass = 0; pass < 4; ++pass) teach(guide, pass, 20000);
  test::Random random(9);
  std::set<uint32_t> met;
  for (uint32_t lanes = 0; lanes <= kAllLanes; ++lanes) {
    Vec3Lanes p, n;
    for (int i = 0; i < kWidth; ++i) {
      p.set(i, {4 * random.next(), 2 * random.next(), 3 * random.next()});
      n.set(i, square_to_uniform_sphere(random.next_2d()));
    }
    GuidePoints found;
    guide.find_each(p, n, lanes, found);
    Vec2Lanes u;
    Vec3Lanes any, drawn;
    FloatLanes pdf_w_of_any, pdf_w_of_drawn;
    for (int i = 0; i < kWidth; ++i) {
      const Vec2 one = random.next_2d();
      u.x[i] = one.x;
      u.y[i] = one.y;
      any.set(i, square_to_uniform_sphere(random.next_2d()));
    }
    guide.sample_each(found, u, lanes, drawn, pdf_w_of_drawn);
    guide.pdf_w_each(found, any, lanes, pdf_w_of_any);
    ExpectationLanes expected;
    const uint32_t credible = guide.expect_each(found, lanes, expected);
    EXPECT_EQ(credible & ~lanes, 0u);
    for_each_lane(lanes, [&](int i) {
      const GuidePoint one = guide.find(p[i], n[i]), &each = found[static_cast<size_t>(i)];
      ASSERT_EQ(each.state, one.state);
      EXPECT_EQ(each.key, one.key);
      EXPECT_EQ(each.frame.x, one.frame.x);
      EXPECT_EQ(each.frame.z, n[i]);
      const GuideSample sample = guide.sample(one, u[i]);
      EXPECT_EQ(drawn[i], sample.wi);
      EXPECT_EQ(pdf_w_of_drawn[i], sample.pdf_w);
      EXPECT_EQ(pdf_w_of_any[i], guide.pdf_w(one, any[i]));
      const GuideExpectation expectation = guide.expectation(one);
      EXPECT_EQ(credible >> i & 1, expectation.credible ? 1u : 0u);
      EXPECT_EQ(expected.arriving[i], expectation.arriving);
      EXPECT_EQ(expected.deviation[i], expectation.deviation);
      met.insert(one.state.value);
    });
  }
  EXPECT_GT(met.size(), 20u);
}

TEST(Adaptive, WhereAllDirectionsPayAlikeItDrawsFromTheBsdf) {
  GuideSetup setup = setup_with();
  setup.adaptive.min_gain = AdaptiveParams{}.min_gain;
  for (bool narrow : {false, true}) {
    AdaptiveGuide guide(setup), loaded(setup);
    for (uint64_t pass = 0; pass < 4; ++pass) teach(guide, pass, 20000, 1, narrow);
    ASSERT_TRUE(loaded.load(guide.save()).ok());
    for (const AdaptiveGuide* g : {&guide, &loaded}) {
      const GuidePoint point = g->find({3.5f, 0, 1}, {0, 1, 0});
      EXPECT_TRUE(g->expectation(point).credible);
      EXPECT_EQ(g->mixture(point, {}).guide, narrow ? 1 : 0);
    }
  }
}

TEST(Adaptive, WhatFadedIsOutweighedSooner) {
  const auto kept = taught(8), faded = taught(8);
  faded->fade(4);
  const auto arriving = [](const AdaptiveGuide& guide) {
    return guide.expectation(guide.find({3.7f, 0, 1}, {0, 1, 0})).arriving.g;
  };
  EXPECT_NEAR(arriving(*faded) / arriving(*kept), 1, 0.02);
  EXPECT_EQ(faded->stats().states, kept->stats().states);
  for (AdaptiveGuide* guide : {kept.get(), faded.get()})
    teach(*guide, 9, 20000, 1, /*narrow=*/true);
  AdaptiveGuide anew(setup_with());
  teach(anew, 9, 20000, 1, /*narrow=*/true);
  EXPECT_LT(arriving(*faded) - arriving(anew), 0.8f * (arriving(*kept) - arriving(anew)));
}

TEST(Adaptive, TheOrderOfEventsChangesNoBit) {
  EXPECT_EQ(bytes_of(*taught(4)), bytes_of(*taught(4, 7)));
}

TEST(Adaptive, SavedLoadedAndSavedAgainItIsTheSameFile) {
  const auto guide = taught(5);
  AdaptiveGuide other(setup_with());
  const Status loaded = other.load(guide->save());
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(bytes_of(other), bytes_of(*guide));
  test::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p{4 * random.next(), 0, 3 * random.next()}, n{0, 1, 0};
    const GuidePoint a = guide->find(p, n), b = other.find(p, n);
    ASSERT_EQ(a.key, b.key);
    ASSERT_EQ(guide->mixture(a, {}).guide, other.mixture(b, {}).guide);
    if (guide->mixture(a, {}).guide == 0) continue;
    const float expected = guide->expectation(a).arriving.r;
    EXPECT_NEAR(other.expectation(b).arriving.r / expected, 1, 0.02);  // sums faded after it
  }
}

uint64_t samples_known(const AdaptiveGuide& guide) {
  uint64_t sum = 0;
  for (const GuidePoint& point : guide.known_points(100'000))
    sum += guide.summary(point).visits.value();
  return sum;
}

TEST(Adaptive, ALongPassDisplacesWhatIsKnown) {
  const auto guide = taught(12);
  const uint64_t known = samples_known(*guide);
  teach(*guide, 200, 200'000);
  EXPECT_NEAR(static_cast<double>(samples_known(*guide)) / static_cast<double>(known + 200'000),
              0.7, 0.03);
}

// Each a thousandth of what is known, and half of it in all.
TEST(Adaptive, ShortPassesAddToWhatIsKnown) {
  const auto guide = taught(12);
  const uint64_t known = samples_known(*guide);
  const int passes = 500, events = static_cast<int>(known / 1000);
  for (uint64_t pass = 0; pass < passes; ++pass) {
    const uint64_t before = samples_known(*guide);
    teach(*guide, 100 + pass, events);
    // Some go to halves that know too little.
    ASSERT_GE(static_cast<double>(samples_known(*guide)), 0.999 * static_cast<double>(before));
  }
  EXPECT_GT(static_cast<double>(samples_known(*guide) - known), 0.75 * passes * events);
}

TEST(Adaptive, WhereNothingIsSeenNothingIsForgotten) {
  const auto guide = taught(12);
  const auto wall = [&] {
    const GuidePoint point = guide->find({3.5f, 1, 0}, {0, 0, 1});
    return std::pair(point.key, guide->summary(point).visits);
  };
  const auto before = wall();
  for (uint64_t pass = 0; pass < 8; ++pass)
    teach(*guide, 100 + pass, 100'000, 1, /*narrow=*/false, /*of_wall=*/0);
  EXPECT_EQ(wall(), before);
}

TEST(Adaptive, WhatItIsWorthGoesWithTheTable) {
  const auto guide = taught(2), other = taught(3), unknown = taught(4);
  const GuideWorth worth{3.5, 7.25};
  guide->set_worth(worth);
  other->set_worth({2.5, 8});
  AdaptiveGuide loaded(setup_with());
  ASSERT_TRUE(loaded.load(guide->save()).ok());
  EXPECT_EQ(loaded.worth(), worth);
  guide->set_worth({1e300, 1e300});
  EXPECT_TRUE(AdaptiveGuide(setup_with()).load(guide->save()).ok()) << "within what is read";
  ASSERT_TRUE(guide->merge(*other).ok());
  EXPECT_EQ(guide->worth(), other->worth()) << "the lesser";
  ASSERT_TRUE(guide->merge(*unknown).ok());
  EXPECT_EQ(guide->worth(), GuideWorth{});
  loaded.fade(4);
  EXPECT_EQ(loaded.worth(), worth);
  loaded.doubt();
  EXPECT_EQ(loaded.worth(), GuideWorth{}) << "in another light";
}

TEST(Adaptive, TablesOfVersions2And8AreRead) {
  const auto guide = taught(2);
  std::vector<TableSection> sections = guide->save();
  sections[0].bytes.resize(sections[0].bytes.size() - 12);  // no worth
  AdaptiveGuide loaded(setup_with());
  ASSERT_TRUE(loaded.load(sections).ok());
  EXPECT_EQ(loaded.worth(), GuideWorth{});
  EXPECT_EQ(bytes_of(loaded), bytes_of(*guide));
  // Version 8: a gain, and what is not read.
  const std::array<double, 2> worth{3.5, 7.25};
  const auto bytes = std::as_bytes(std::span(worth));
  for (const std::byte b : bytes) sections[0].bytes.push_back(static_cast<uint8_t>(b));
  AdaptiveGuide of_8(setup_with());
  ASSERT_TRUE(of_8.load(sections).ok());
  EXPECT_EQ(of_8.worth(), (GuideWorth{3.5, 0}));
  sections[0].bytes.pop_back();
  EXPECT_FALSE(AdaptiveGuide(setup_with()).load(sections).ok());
}

TEST(Adaptive, AFullTableLearnsNoMoreStatesAndSaysSo) {
  constexpr size_t kBytes = 200'000;
  AdaptiveGuide guide(setup_with(kBytes));
  for (uint64_t pass = 0; pass < 10; ++pass) teach(guide, pass, 40000);
  EXPECT_LE(guide.stats().bytes, kBytes);
  EXPECT_GT(guide.stats().bytes, kBytes / 2);
  EXPECT_GT(guide.stats().refused, 0u);
  AdaptiveGuide tiny(setup_with(1));
  teach(tiny, 1, 1000);
  EXPECT_EQ(tiny.stats().states, 0u);
  EXPECT_GT(tiny.stats().refused, 0u);
}

TEST(Adaptive, TablesOfDifferentRefinementMergeInEitherOrder) {
  const auto few = taught(1), many = taught(12);
  ASSERT_GT(many->stats().states, 2 * few->stats().states);
  const auto a = taught(1), b = taught(12);
  ASSERT_TRUE(a->merge(*many).ok());
  ASSERT_TRUE(b->merge(*few).ok());
  EXPECT_EQ(bytes_of(*a), bytes_of(*b));
  EXPECT_GE(a->stats().states, many->stats().states);
  EXPECT_EQ(a->stats().samples_seen, 13u * 20000);
  // What it expects lies between what they expected: but where a place had too few samples of its
  // own to be believed, and still told what it was cut from.
  test::Random random(6);
  int known = 0, between = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p{4 * random.next(), 0, 3 * random.next()}, n{0, 1, 0};
    const auto expected = [&](const AdaptiveGuide& guide) {
      return guide.expectation(guide.find(p, n)).arriving.g;
    };
    if (expected(*few) == 0) continue;
    const auto [lo, hi] = std::minmax({expected(*few), expected(*many)});
    ASSERT_EQ(expected(*a), expected(*b));
    between += expected(*a) > 0.99f * lo && expected(*a) < 1.01f * hi;
    ++known;
  }
  EXPECT_GT(known, 150);
  EXPECT_GT(between, 0.9 * known);
}

TEST(Adaptive, AMergeWithoutRoomLeavesTheTableAsItWas) {
  const auto other = taught(5);
  AdaptiveGuide guide(setup_with(other->stats().bytes));
  for (uint64_t pass = 20; pass < 25; ++pass) teach(guide, pass, 20000);
  const Bytes before = bytes_of(guide);
  const Status full = guide.merge(*other);
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(bytes_of(guide), before);
  GuideSetup elsewhere = setup_with();
  elsewhere.brightest_light = 5000;
  EXPECT_EQ(AdaptiveGuide(elsewhere).merge(*other).error().code, ErrorCode::kConflict);
}

// A record as save() writes it: of one leaf of the directions in each quarter.
void write_state(ByteWriter& out, uint64_t key, int64_t n = 100, int64_t second = 40,
                 int64_t sum_of_cell = int64_t{1} << 30) {
  out.u64(key);
  out.i64(n);
  out.i64(second);
  for (int sum = 0; sum < 5; ++sum) out.i64(int64_t{1} << 32);
  out.u8(1);
  for (int q = 0; q < 4; ++q) {
    out.u8(0);
    out.i64(sum_of_cell);
    out.u32(25);
  }
}

Status load_states(std::initializer_list<uint64_t> keys, int64_t n = 100, int64_t second = 40) {
  AdaptiveGuide guide(setup_with());
  std::vector<TableSection> sections = guide.save();
  ByteWriter out;
  out.u64(keys.size());
  for (uint64_t key : keys) write_state(out, key, n, second);
  sections[1].bytes = out.take();
  sections.resize(2);  // as version 4 wrote it
  return guide.load(sections);
}

Status load_sum(AdaptiveGuide& guide, int64_t sum_of_cell) {
  std::vector<TableSection> sections = guide.save();
  ByteWriter out;
  out.u64(1);
  write_state(out, /*the floor*/ 1 << 3 | 2, 100, 40, sum_of_cell);
  sections[1].bytes = out.take();
  sections.resize(2);
  return guide.load(sections);
}

TEST(Adaptive, SumsThatMayNotFitAreRefused) {
  constexpr int64_t kMost = int64_t{1} << 58;  // in each quarter
  AdaptiveGuide a(setup_with()), b(setup_with()), too_large(setup_with()), wrapped(setup_with());
  EXPECT_EQ(load_sum(too_large, kMost + 1).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(load_sum(wrapped, kMost << 4).error().code, ErrorCode::kCorrupt);
  ASSERT_TRUE(load_sum(a, kMost).ok());
  ASSERT_TRUE(load_sum(b, 1).ok());
  const Bytes before = bytes_of(a);
  EXPECT_EQ(a.merge(b).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(bytes_of(a), before);
}

TEST(Adaptive, ItsRecordsAreChecked) {
  constexpr uint64_t kFloor = 2;  // the face +y
  const auto key = [](uint64_t halves, uint64_t face) { return halves << 3 | face; };
  EXPECT_TRUE(load_states({key(1, kFloor), key(1, 4)}).ok());
  EXPECT_TRUE(load_states({key(0b10, kFloor), key(0b11, kFloor), key(0b100, 4)}).ok());
  EXPECT_TRUE(load_states({key(1, kFloor)}, 100, 100).ok());
  const auto refused = [](const Status& status, const std::string& says) {
    ASSERT_FALSE(status.ok()) << says;
    EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
    EXPECT_NE(status.error().text().find(says), std::string::npos) << status.error().text();
    EXPECT_NE(status.error().where.find("table:AQTD"), std::string::npos) << status.error().where;
  };
  refused(load_states({key(0b11, kFloor), key(0b10, kFloor)}), "rising");
  refused(load_states({key(1, kFloor), key(1, kFloor)}), "rising");
  refused(load_states({key(1, kFloor), key(0b11, kFloor)}), "hold one another");
  refused(load_states({key(1, kFloor), key(0b1010, kFloor)}), "hold one another");
  refused(load_states({key(0b11, 3), key(0b1100, 3), key(0b1101, 3)}), "hold one another");
  refused(load_states({key(1, 6)}), "key");
  refused(load_states({5}), "key");
  refused(load_states({uint64_t{1} << 46}), "key");
  refused(load_states({key(1, kFloor)}, 100, 101), "sums");
  refused(load_states({key(1, kFloor)}, 100, -1), "sums");
  refused(load_states({key(1, kFloor)}, 0, 0), "sums");
  refused(load_states({key(1, kFloor)}, -5, 0), "sums");
}

TEST(Adaptive, WhatLobesShareGoesWithTheTable) {
  const auto guide = taught(5);
  std::vector<TableSection> sections = guide->save();
  ASSERT_EQ(sections[2].tag, "ALOB");
  EXPECT_TRUE(std::ranges::any_of(sections[2].bytes, [](uint8_t byte) { return byte != 0; }));
  AdaptiveGuide loaded(setup_with());
  ASSERT_TRUE(loaded.load(sections).ok());
  EXPECT_EQ(loaded.save()[2].bytes, sections[2].bytes);
  for (const bool longer : {false, true}) {
    std::vector<TableSection> damaged = sections;
    damaged[2].bytes.resize(sections[2].bytes.size() + (longer ? 8 : -8));
    AdaptiveGuide other(setup_with());
    const Status refused = other.load(damaged);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  }
}

TEST(Adaptive, ATableThatIsTooLargeOrOfAnotherCubeIsRefused) {
  const auto guide = taught(5);
  AdaptiveGuide small(setup_with(10'000));
  const Status large = small.load(guide->save());
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().code, ErrorCode::kTooLarge);
  GuideSetup elsewhere = setup_with();
  elsewhere.bounds.hi.x = 40;
  AdaptiveGuide other(elsewhere);
  const Status conflict = other.load(guide->save());
  ASSERT_FALSE(conflict.ok());
  EXPECT_EQ(conflict.error().code, ErrorCode::kConflict);
}

TEST(Adaptive, NoFiniteEventSpoilsTheTable) {
  AdaptiveGuide guide(setup_with());
  for (int pass = 0; pass < 4; ++pass) {
    teach(guide, 1, 5000);
    GuideVertex v;
    v.at = guide.find({1, 0, 1}, {0, 1, 0});
    v.guidable = true;
    v.wi = {0, 1, 0};
    for (float pdf : {1e-30f, 1e30f})
      for (float radiance : {1e30f, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()}) {
        v.pdf_w = pdf;
        v.arriving = Rgb{radiance};
        guide.record({&v, 1}, *guide.make_delta());
      }
  }
  const GuidePoint point = guide.find({1, 0, 1}, {0, 1, 0});
  EXPECT_LT(guide.expectation(point).arriving.r, 5);
  EXPECT_TRUE(std::isfinite(guide.pdf_w(point, {0, 1, 0})));
}

}  // namespace
}  // namespace qray
