#include "core/render/debug_view.h"

#include <gtest/gtest.h>

#include <set>

#include "core/image/false_color.h"
#include "core/job/run_job.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// A white floor under a light, a mirror beside it, and nothing around them.
Scene open_scene() {
  Scene scene;
  scene.name = "open";
  test::add_quad(scene, test::add_material(scene, Rgb{0.7f}), {-2, 0, 2}, {2, 0, 0}, {0, 0, -4});
  const MaterialId mirror = test::add_material(scene, Rgb{0.9f});
  scene.materials[mirror.value].kind = MaterialKind::kConductor;
  test::add_quad(scene, mirror, {0, 0, 2}, {2, 0, 0}, {0, 0, -4});
  test::add_quad(scene, test::add_material(scene, Rgb{0.0f}, Rgb{20.0f}), {-1, 2, -1}, {1, 0, 0},
                 {0, 0, 1});
  scene.camera.position = {0, 1, 4};
  scene.camera.target = {0, 0.5f, 0};
  return scene;
}

RenderSettings settings_of(const char* method) {
  RenderSettings settings;
  settings.method = method;
  settings.width = 40;
  settings.height = 30;
  settings.samples = 64;
  settings.learning_samples = 16;
  settings.adaptive.min_gain = 0;  // so that uniform places are guided
  return settings;
}

struct Taught {
  std::shared_ptr<const PreparedScene> scene;
  RenderSettings settings;
  std::unique_ptr<Guide> guide;

  Taught(Scene from, const char* method, bool learns = true)
      : scene(test::prepare(std::move(from))), settings(settings_of(method)) {
    std::optional<TableFile> table;
    if (learns) {
      Film film(settings.width, settings.height);
      TaskPool pool(2);
      RenderObserver observer;
      auto job = run_job(*scene, settings, std::nullopt, film, pool, observer, {}, SteadyClock());
      table = std::move(job).value().table;
    }
    guide = load_guide(*scene, settings, table).value();
  }
  Image draw(DebugView view) const {
    TaskPool pool(2);
    return render_debug_view(*scene, settings, view, guide.get(), 1, pool, {}).value();
  }
};

std::set<std::tuple<float, float, float>> colors_of(const Image& image) {
  std::set<std::tuple<float, float, float>> colors;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const Rgb c = image.rgb(x, y);
      colors.insert({c.r, c.g, c.b});
    }
  return colors;
}
std::tuple<float, float, float> color(Rgb c) { return {c.r, c.g, c.b}; }

TEST(DebugView, HasANameAndAScaleForEach) {
  for (const char* name : {"albedo", "normal", "state", "beta", "gain"}) {
    const auto view = parse_debug_view(name);
    ASSERT_TRUE(view) << name;
    EXPECT_FALSE(scale_of(*view).empty());
  }
  EXPECT_FALSE(shows_guide(*parse_debug_view("normal")));
  EXPECT_TRUE(shows_guide(*parse_debug_view("state")));
  EXPECT_FALSE(parse_debug_view("lobe"));
  EXPECT_FALSE(parse_debug_view(""));
}

TEST(DebugView, AnUntaughtGuideIsOneColourAndTheRestIsBlack) {
  for (const char* method : {"dahm-keller", "ppg", "adaptive"}) {
    const Taught cold(open_scene(), method, /*learns=*/false);
    for (DebugView view : {DebugView::kBeta, DebugView::kGain}) {
      const auto colors = colors_of(cold.draw(view));
      EXPECT_EQ(colors.size(), 2u) << method;
      EXPECT_TRUE(colors.contains(color(Rgb{}))) << method;
      EXPECT_TRUE(colors.contains(color(viridis(0)))) << method;
    }
  }
}

TEST(DebugView, TaughtItShowsWhereItGuidesAndWhatItGains) {
  for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"}) {
    const Taught taught(test::room(), method);
    const Image state = taught.draw(DebugView::kState), beta = taught.draw(DebugView::kBeta),
                gain = taught.draw(DebugView::kGain);
    EXPECT_GT(colors_of(state).size(), 2u) << method;
    EXPECT_GT(colors_of(gain).size(), 2u) << method;
    int guided = 0;
    for (int y = 0; y < beta.height(); ++y)
      for (int x = 0; x < beta.width(); ++x) guided += beta.rgb(x, y) != viridis(0);
    EXPECT_GT(guided, beta.width() * beta.height() / 2) << method;
  }
}

TEST(DebugView, PlacesThatTheTableDoesNotHaveAreBlack) {
  Taught taught(test::room(), "huang");
  EXPECT_FALSE(colors_of(taught.draw(DebugView::kState)).contains(color(Rgb{})));
  // The same table, and a surface that no path has seen.
  Scene changed = test::room();
  test::add_box(changed, MaterialId(0), {-0.9f, 0.5f, 0}, {-0.4f, 1.3f, 0.4f}, false);
  taught.scene = test::prepare(changed);
  EXPECT_TRUE(colors_of(taught.draw(DebugView::kState)).contains(color(Rgb{})));
}

TEST(DebugView, StopsWhenAsked) {
  const Taught cold(test::room(), "huang", /*learns=*/false);
  std::stop_source stop;
  stop.request_stop();
  TaskPool pool(1);
  const auto image = render_debug_view(*cold.scene, cold.settings, DebugView::kState,
                                       cold.guide.get(), 1, pool, stop.get_token());
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::kCanceled);
}

}  // namespace
}  // namespace qray
