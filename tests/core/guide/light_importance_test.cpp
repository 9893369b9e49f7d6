#include "core/guide/light_importance.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/guide/adaptive_layout.h"
#include "tests/core/guide/taught.h"
#include "tests/support/random.h"

namespace qray {
namespace {

// Three lights picked by their power, and eight clusters of a tree.
LightClusters clusters() {
  LightClusters c;
  c.bounds = test::setup_of().bounds;
  c.groups = {{{0.5f, 0.25f, 0.25f}, 3}, {{}, 8}};
  c.fingerprint = 7;
  return c;
}

const Vec3 kSomewhere = clusters().bounds.center();

// The third light is behind a wall, and of the tree the first cluster sends twice what is expected.
void teach_lights(const LightImportance& lights, uint64_t seed, int picks = 600) {
  test::Random random(seed);
  const uint32_t place = lights.place(kSomewhere, {0, 1, 0});
  for (int i = 0; i < picks; ++i) {
    const auto light = static_cast<uint32_t>(3 * random.next());
    const auto child = static_cast<uint32_t>(8 * random.next());
    lights.record(place, std::array{ClusterPick{light, 1}}, light == 2 ? 0.0f : 1.0f);
    lights.record(place, std::array{ClusterPick{3 + child, 1}}, child == 0 ? 2.0f : 1.0f);
  }
}

TEST(LightImportance, PicksMoreOftenWhatSendsMore) {
  LightImportance lights(clusters());
  const uint32_t place = lights.place(kSomewhere, {0, 1, 0});
  teach_lights(lights, 1);
  EXPECT_EQ(lights.weights(place), nullptr) << "before the pass ends";
  lights.end_pass();
  const float* w = lights.weights(place);
  ASSERT_NE(w, nullptr);
  EXPECT_NEAR(w[0], 2 / 3.0, 0.06);  // of 2 : 1 : little
  EXPECT_EQ(w[2], 1);
  const float hidden = w[2] - w[1];
  EXPECT_GT(hidden, 0.02);  // never nothing: it may be seen from elsewhere in the place
  EXPECT_LT(hidden, 0.1);
  EXPECT_NEAR(w[3] / w[5], 2, 0.1);
  EXPECT_EQ(lights.weights(lights.place(kSomewhere, {0, -1, 0})), nullptr) << "the other face";
}

// What few picks say is hardly believed; what is no number is not counted.
TEST(LightImportance, FewPicksChangeLittle) {
  LightImportance lights(clusters());
  const uint32_t place = lights.place(kSomewhere, {});
  for (int i = 0; i < 40; ++i) lights.record(place, std::array{ClusterPick{0, 1}}, 1);
  lights.record(place, std::array{ClusterPick{2, 1}}, 0);
  lights.record(place, std::array{ClusterPick{1, 1}}, std::numeric_limits<float>::quiet_NaN());
  lights.record(place, std::array{ClusterPick{1, std::numeric_limits<float>::infinity()}}, 1);
  lights.end_pass();
  const float* w = lights.weights(place);
  ASSERT_NE(w, nullptr);
  EXPECT_NEAR(w[0], 0.5, 0.03);
  EXPECT_NEAR(w[1], 0.75, 0.03);
  for (int i = 3; i < 11; ++i) EXPECT_EQ(w[i], 1);
}

TEST(LightImportance, PlacesOutsideAreTheNearest) {
  const LightImportance lights(clusters());
  const Bounds3& box = clusters().bounds;
  EXPECT_EQ(lights.place(box.lo - Vec3{9, 9, 9}, {0, 0, 1}), lights.place(box.lo, {0, 0, 1}));
  EXPECT_EQ(lights.place(box.hi + Vec3{9, 9, 9}, {0, 0, 1}),
            lights.place(box.hi - Vec3{1e-3f, 1e-3f, 1e-3f}, {0, 0, 1}));
  EXPECT_LT(lights.place({NAN, NAN, NAN}, {0, 0, 1}), LightImportance::kPlaces);
}

TEST(LightImportance, ThreadsAndOrderChangeNoBit) {
  LightImportance one(clusters()), many(clusters());
  for (uint64_t seed = 1; seed <= 4; ++seed) teach_lights(one, seed);
  std::vector<std::jthread> threads;
  for (uint64_t seed = 4; seed >= 1; --seed)
    threads.emplace_back([&, seed] { teach_lights(many, seed); });
  threads.clear();
  EXPECT_EQ(one.save(), many.save());
}

TEST(LightImportance, ACopyLearnsWhatTheWholeWouldHave) {
  LightImportance alone(clusters()), whole(clusters()), copy(clusters());
  teach_lights(alone, 1), teach_lights(alone, 2);
  alone.end_pass();
  teach_lights(whole, 1);
  teach_lights(copy, 2);
  ByteWriter out;
  copy.take_learned(out);
  EXPECT_FALSE(copy.has_learned());
  ByteReader in(out.data());
  LightImportance::Learned learned;
  ASSERT_TRUE(whole.read_learned(in, learned));
  EXPECT_EQ(in.remaining(), 0u);
  whole.add(learned);
  whole.end_pass();
  EXPECT_EQ(whole.save(), alone.save());
  for (size_t size = 0; size < out.size(); ++size) {
    ByteReader cut(std::span(out.data()).first(size));
    LightImportance::Learned ignored;
    EXPECT_FALSE(whole.read_learned(cut, ignored)) << size;
  }
}

TEST(LightImportance, ComesBackFromATableAndIsMerged) {
  LightImportance a(clusters()), b(clusters());
  teach_lights(a, 1), teach_lights(b, 2);
  a.end_pass(), b.end_pass();
  const Result<LightImportance> back = LightImportance::load(a.save());
  ASSERT_TRUE(back.ok());
  const uint32_t place = a.place(kSomewhere, {0, 1, 0});
  for (int i = 0; i < 11; ++i) EXPECT_EQ(back.value().weights(place)[i], a.weights(place)[i]) << i;
  EXPECT_TRUE(back.value().clusters() == clusters());
  LightImportance ab = a, ba = b;
  ASSERT_TRUE(ab.merge(b) && ba.merge(a));
  EXPECT_EQ(ab.save(), ba.save());
  LightClusters others = clusters();
  others.fingerprint = 8;
  EXPECT_FALSE(ab.merge(LightImportance(others)));
  const Bytes good = a.save();
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(LightImportance::load(std::span(good).first(size)).ok()) << size;
  for (size_t byte = 0; byte < good.size(); ++byte) {  // no damage may hurt
    Bytes bad = good;
    bad[byte] ^= 0x81;
    (void)LightImportance::load(bad);
  }
}

// The guide keeps it: in its table, its state, its copies and its sums.
TEST(LightImportance, GoesWithTheGuide) {
  GuideSetup setup = test::setup_of();
  setup.lights = clusters();
  const std::unique_ptr<Guide> guide = test::taught("adaptive", 1, setup);
  teach_lights(*guide->light_importance(), 1);
  guide->end_pass();
  const std::vector<TableSection> sections = guide->save();
  ASSERT_EQ(sections.back().tag, "ALIT");
  const Result<GuideSetup> again = setup_of_table("adaptive", sections);
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again.value().lights == clusters());
  const std::unique_ptr<Guide> loaded = make_guide("adaptive", setup).value();
  ASSERT_TRUE(loaded->load(sections).ok());
  EXPECT_EQ(loaded->save().back().bytes, sections.back().bytes);

  const std::unique_ptr<Guide> copy = make_guide("adaptive", setup).value();
  Bytes state;
  SnapshotWriter out([&](std::span<const uint8_t> bytes) {
    state.insert(state.end(), bytes.begin(), bytes.end());
  });
  guide->share()->save_copy(out);
  SnapshotReader in{std::span<const uint8_t>(state)};
  copy->share()->load_copy(in);
  ASSERT_TRUE(in.ok());
  const uint32_t here = guide->light_importance()->place(kSomewhere, {0, 1, 0});
  for (int i = 0; i < 11; ++i)
    EXPECT_EQ(copy->light_importance()->weights(here)[i],
              guide->light_importance()->weights(here)[i]);
  EXPECT_FALSE(copy->light_importance()->has_learned());

  setup.lights.fingerprint = 8;  // other lights
  const std::unique_ptr<Guide> elsewhere = make_guide("adaptive", setup).value();
  ASSERT_TRUE(elsewhere->load(sections).ok());
  EXPECT_NE(elsewhere->save().back().tag, "ALIT");

  loaded->fade(16);
  const uint32_t place = loaded->light_importance()->place(kSomewhere, {0, 1, 0});
  const float sure = guide->light_importance()->weights(place)[1],
              doubted = loaded->light_importance()->weights(place)[1];
  EXPECT_GT(sure, doubted);
  EXPECT_GT(doubted, 0.75f);
  loaded->set_lights(setup.lights);
  EXPECT_EQ(loaded->light_importance()->weights(place), nullptr);
  EXPECT_NE(loaded->save().back().tag, "ALIT");
}

}  // namespace
}  // namespace qray
