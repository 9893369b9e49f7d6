#include "core/settings/variant.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(Variant, SetsWhatItNames) {
  const RenderSettings s =
      apply_variant(
          "huang:nee=off;grid=12;alpha=.5;gamma=0.25;learning=3;depth=4;roulette=off;"
          "light-table=off",
          {})
          .value();
  EXPECT_EQ(s.method, "huang");
  EXPECT_FALSE(s.nee);
  EXPECT_FALSE(s.russian_roulette);
  EXPECT_FALSE(s.light_table);
  EXPECT_EQ(s.huang.grid, 12);
  EXPECT_EQ(s.huang.alpha, 0.5f);
  EXPECT_EQ(s.huang.gamma, 0.25f);
  EXPECT_EQ(s.learning_samples, 3);
  EXPECT_EQ(s.max_depth, 4);
}

TEST(Variant, LeavesTheRest) {
  RenderSettings base;
  base.width = 33;
  base.max_depth = 5;
  base.nee = false;
  const RenderSettings s = apply_variant("none:nee=on", base).value();
  EXPECT_EQ(s.method, "none");
  EXPECT_EQ(s.width, 33);
  EXPECT_EQ(s.max_depth, 5);
  EXPECT_TRUE(s.nee);
}

TEST(Variant, ListsKeepTheirOrder) {
  EXPECT_EQ(parse_variants("none,huang:grid=12;nee=off,huang").value(),
            (std::vector<std::string>{"none", "huang:grid=12;nee=off", "huang"}));
}

TEST(Variant, ErrorsNameWhatWasExpected) {
  struct Case {
    const char *list, *expected;
  };
  const Case cases[] = {{"nope", "none, huang-published, huang"},
                        {"", "expected one of none"},
                        {"none,,huang", "expected one of none"},
                        {"huang:", "key=value after the colon"},
                        {"huang:speed=9", "unknown key 'speed', expected one of nee, pixels"},
                        {"huang:nee=yes", "nee: expected on or off, got 'yes'"},
                        {"huang:nee", "nee: expected on or off, got ''"},
                        {"huang:grid=2x", "grid: expected a whole number, 1..512, got '2x'"},
                        {"huang:grid=0", "/guide/grid: expected 1..512, got 0"},
                        {"huang:gamma=2", "/guide/gamma: expected 0..1, got 2"},
                        {"huang:gamma=nan", "/guide/gamma"},
                        {"adaptive:grid=3",
                         "grid: the method adaptive has no such setting: it belongs to huang, "
                         "huang-published, dahm-keller"},
                        {"none:recover=auto",
                         "recover: expected one of none, bilinear, untrained, "
                         "default, oidn, got 'auto'"},
                        {"none,huang,none", "twice"}};
  for (const Case& c : cases) {
    const auto variants = parse_variants(c.list);
    ASSERT_FALSE(variants.ok()) << c.list;
    EXPECT_NE(variants.error().text().find(c.expected), std::string::npos)
        << c.list << ": " << variants.error().text();
    EXPECT_NE(variants.error().where.find("method '"), std::string::npos) << c.list;
  }
}

TEST(Variant, Traits) {
  EXPECT_FALSE(method_traits("none:nee=off").keeps_table);
  EXPECT_TRUE(method_traits("none").unbiased);
  EXPECT_TRUE(method_traits("huang:grid=3").keeps_table);
  EXPECT_TRUE(method_traits("huang").unbiased);
  EXPECT_FALSE(method_traits("huang-published:grid=3").unbiased);
}

}  // namespace
}  // namespace qray
