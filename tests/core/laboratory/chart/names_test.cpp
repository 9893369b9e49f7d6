#include "core/laboratory/chart/names.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(ChartNames, AreSafeInEveryFileSystem) {
  EXPECT_EQ(chart_file_name("huang:grid=12;nee=off"), "huang-grid-12-nee-off");
  EXPECT_EQ(chart_file_name("Cornell Box/../x"), "cornell-box-..-x");
  EXPECT_EQ(chart_picture("room", "huang:alpha=0.5", true), "room/huang-alpha-0.5-warm.png");
  EXPECT_EQ(chart_picture("room", "none", false), "room/none.png");
  EXPECT_EQ(chart_error_picture("room", "none", false), "room/none-error.png");
  EXPECT_EQ(chart_error_picture("room", "huang", true), "room/huang-warm-error.png");
  EXPECT_EQ(chart_reference_picture("room"), "room/reference.png");
}

}  // namespace
}  // namespace qray
