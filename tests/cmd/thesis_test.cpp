#include "core/image/image_io.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

class ThesisCommand : public ::testing::Test {
 protected:
  Image figure(const char* number, std::vector<std::string> more = {}) const {
    const std::string out = (scratch_ / (std::string(number) + ".exr")).string();
    std::vector<std::string> arguments{"thesis", "--figure", number, "--size", "32x24", "-o", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome done = qray_command(arguments);
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    const auto image = read_image(out);
    EXPECT_TRUE(image.ok()) << out;
    return image.ok() ? image.value() : Image(1, 1, 3);
  }
  ScratchFolder scratch_;
};

double mean_of(const Image& image, int x_begin, int x_end) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = x_begin; x < x_end; ++x) sum += luminance(image.rgb(x, y));
  return sum / (static_cast<double>(image.height()) * (x_end - x_begin));
}

TEST_F(ThesisCommand, ComparesHalvesWithBothReadings) {
  const Image both = figure("10");
  ASSERT_EQ(both.width(), 32 + 8 + 32);
  ASSERT_EQ(both.height(), 24);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 16; ++x)
      ASSERT_EQ(both.rgb(x, y), both.rgb(x + 40, y)) << "the halves without learning are the same";
  EXPECT_GT(mean_of(both, 16, 32), 1.1 * mean_of(both, 56, 72))
      << "the published method is brighter than the corrected one";

  const Image corrected = figure("10", {"--method", "huang"});
  ASSERT_EQ(corrected.width(), 32);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) ASSERT_EQ(corrected.rgb(x, y), both.rgb(x + 40, y));
}

TEST_F(ThesisCommand, ShowsAnotherViewInFigure11) {
  const Image first = figure("10", {"--method", "huang"});
  const Image second = figure("11", {"--method", "huang"});
  int different = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) different += first.rgb(x, y) != second.rgb(x, y);
  EXPECT_GT(different, 32 * 24 / 4);  // many are black in both
}

TEST_F(ThesisCommand, ColoursStatesFlatly) {
  const Image states = figure("8");
  std::vector<Rgb> colors;
  for (int y = 0; y < states.height(); ++y)
    for (int x = 0; x < states.width(); ++x) {
      const Rgb c = states.rgb(x, y);
      bool known = false;
      for (const Rgb& other : colors) known = known || other == c;
      if (!known) colors.push_back(c);
    }
  EXPECT_GT(colors.size(), 10u);
}

TEST_F(ThesisCommand, DrawsTheDirections) {
  const Image cube = figure("9");
  int red = 0, green = 0, blue = 0, white = 0;
  for (int y = 0; y < cube.height(); ++y)
    for (int x = 0; x < cube.width(); ++x) {
      const Rgb c = cube.rgb(x, y);
      red += c.r > c.g + 0.1f && c.r > c.b + 0.1f;
      green += c.g > c.r + 0.1f && c.g > c.b + 0.1f;
      blue += c.b > c.r + 0.1f && c.b > c.g + 0.1f;
      white += c == Rgb{1.0f};
    }
  EXPECT_GT(red, 0);
  EXPECT_GT(green, 0);
  EXPECT_GT(blue, 0);
  EXPECT_GT(white, 32 * 24 / 4);
}

TEST_F(ThesisCommand, KnowsItsFigures) {
  EXPECT_EQ(qray_command({"thesis", "--figure", "7", "-o", "x.png"}).code, cmd::kExitBadInput);
}

}  // namespace
}  // namespace qray::test
