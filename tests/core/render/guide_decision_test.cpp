// What a table is worth, as jobs leave it.
#include "core/render/guide_decision.h"

#include <gtest/gtest.h>

#include "tests/support/render.h"

namespace qray {
namespace {

GuideWorth worth_of(const PreparedScene& scene, const RenderSettings& settings,
                    const TableFile& table) {
  return load_guide(scene, settings, table).value()->worth();
}

// A job that measures otherwise than those before it moves it, but not all the way.
TEST(GuideDecision, ATablesWorthChangesByWhatItHasLearnedSince) {
  const auto scene = test::included_scene("ajar-door");
  const RenderSettings settings = test::small_settings("adaptive", 64, 64);
  TableFile table = *test::render(*scene, settings).job.table;
  const GuideWorth first = worth_of(*scene, settings, table);
  ASSERT_GT(first.efficiency_gain, 0);
  const auto guide = load_guide(*scene, settings, table).value();
  guide->set_worth({100 * first.efficiency_gain, first.unguided_cost});
  table.sections = guide->save();
  const TableFile next = *test::render(*scene, settings, table).job.table;
  const double gain = worth_of(*scene, settings, next).efficiency_gain;
  EXPECT_GT(gain, 2 * first.efficiency_gain);
  EXPECT_LT(gain, 50 * first.efficiency_gain);
}

}  // namespace
}  // namespace qray
