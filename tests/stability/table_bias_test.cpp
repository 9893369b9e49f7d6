// The thesis' method as it was printed brightens the picture: by how much, in rooms and where the
// answer is known. The same choice of directions divided by its density does not.
#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/random.h"

namespace qray {
namespace {

using test::formatted;

test::Moments pictures(const test::Sampled& sampled) {
  test::Moments means;
  for (const std::vector<double>& m : sampled.means) means.add(m[0]);
  return means;
}

TEST(TableBias, ThePublishedMethodBrightensRooms) {
  const test::FailureMode mode("published-method");
  for (const char* name : {"cornell-box", "thesis-room", "lamp-room"})
    for (bool nee : {false, true}) {
      if (!nee && std::string_view(name) == "lamp-room") continue;  // its noise hides all
      const auto scene = test::included_scene(name);
      RenderSettings settings = test::small_settings("none", 32, 16);
      settings.nee = nee;
      const std::string label = std::string(name) + (nee ? ", nee" : "");
      const test::SeedOptions cold{.seeds = 24, .regions = 2, .table = {}};
      test::SeedOptions warm = cold;
      warm.table = [&](const std::string& method) {
        return test::learned_table(*scene, settings, method);
      };
      const test::Sampled none = test::sample_seeds(*scene, settings, "none", cold);
      // That the others have the right mean in these rooms: tests/stat/unbiased_test.cpp.
      const test::Sampled sampled = test::sample_seeds(*scene, settings, "huang-published", warm);
      EXPECT_FALSE(sampled.unbiased);
      test::check_method(mode, label, sampled, none, nullptr);
      EXPECT_GT(test::z_test(pictures(sampled), pictures(none)).z, 5) << label;
      if (!nee) {
        EXPECT_GT(sampled.mean() / none.mean(), 1.3) << label;
      }
    }
}

// Light reflected by a patch of albedo 1 as Algorithm 1 samples it, over what it reflects: the cell
// straight above sends `bright`, all others 1.
double brightening(HuangGuide::Density density, float bright) {
  const Vec3 n{0, 0, 1}, p{0.4f, 0.3f, 0.6f};
  HuangGuide::Values radiance;
  radiance.fill(1);
  radiance[static_cast<size_t>(nearest_direction26(n))] = bright;
  HuangGuide guide(density, {{0, 0, 0}, {1, 1, 1}}, {});
  guide.set_values(guide.find(p, n).key, radiance);
  guide.end_pass();
  const GuidePoint point = guide.find(p, n);
  const auto from = [&](Vec3 wi) { return radiance[static_cast<size_t>(nearest_direction26(wi))]; };
  test::Random random(31);
  double reflected = 0, truth = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const GuideSample s = guide.sample(point, random.next_2d());
    reflected += static_cast<double>(from(s.wi) * s.wi.z * kInvPi / s.pdf_w);
    truth += static_cast<double>(from(square_to_cosine_hemisphere(random.next_2d())));
  }
  return reflected / truth;
}

TEST(TableBias, ThePublishedMethodBrightensAPatchAsDerived) {
  const test::FailureMode mode("published-method");
  const struct {
    float bright;
    double published;
  } cases[] = {{2, 1.7}, {10, 3.8}, {100, 5.1}};
  for (const auto& c : cases) {
    const double published = brightening(HuangGuide::Density::kAsPublished, c.bright);
    const double exact = brightening(HuangGuide::Density::kExact, c.bright);
    EXPECT_NEAR(published, c.published, 0.06);  // the figures have one decimal
    EXPECT_NEAR(exact, 1, 0.01);
    mode.says("huang-published",
              formatted("on the patch with one direction %g times as bright: %.2f times too bright",
                        double{c.bright}, published));
    mode.says("huang",
              formatted("on the patch with one direction %g times as bright: %.3f times the truth",
                        double{c.bright}, exact));
  }
}

}  // namespace
}  // namespace qray
