#include "core/settings/job_fields.h"

#include <type_traits>

#include "core/guide/guide.h"
#include "core/guide/surface_grid.h"

namespace qray {
namespace {

constexpr unsigned kEverywhere = kJob | kLive | kRender | kSubmit | kVariant;
constexpr unsigned kOfJobs = kJob | kRender | kSubmit;  // neither of sessions nor of charts
constexpr unsigned kOfServer = kJob | kSubmit;
constexpr int kMaxSidePx = 8192;
constexpr double kMaxSeconds = 24 * 3600;
constexpr double kMaxLengthM = 1e6;
const std::string kScenes = "left out: the scene's";

// What a new method adds to this file, beside its settings: the words for who chooses it.
constexpr std::pair<std::string_view, const char*> kMethodLabels[] = {
    {"none", "none: no learning"},
    {"huang-published", "huang as published: learns, biased"},
    {"huang", "huang: learns, unbiased"},
    {"dahm-keller", "Dahm-Keller: learns radiance in 64 directions, unbiased"},
    {"ppg", "PPG (practical path guiding): learns, unbiased"},
    {"adaptive", "adaptive: learns where light comes from, unbiased"}};

// A member of RenderSettings as a setting: `member` gives a reference to it.
template <class Member>
SettingOfField setting(Member member) {
  using T = std::remove_cvref_t<decltype(member(std::declval<RenderSettings&>()))>;
  return {[member](RenderSettings& s, const FieldValue& value) {
            std::visit(
                [&](const auto& v) {
                  if constexpr (std::is_arithmetic_v<T> &&
                                std::is_arithmetic_v<std::remove_cvref_t<decltype(v)>>)
                    member(s) = static_cast<T>(v);
                  else if constexpr (std::is_same_v<T, std::remove_cvref_t<decltype(v)>>)
                    member(s) = v;
                },
                value);
          },
          [member](const RenderSettings& s) -> std::optional<FieldValue> {
            const T& value = member(const_cast<RenderSettings&>(s));
            if constexpr (std::is_same_v<T, float>)
              return FieldValue(short_double(value));
            else if constexpr (std::is_same_v<T, int>)
              return FieldValue(int64_t{value});
            else
              return FieldValue(value);
          }};
}

// The same, but what does not pass `asked` counts as not asked for.
template <class Member, class Asked>
SettingOfField setting_if(Member member, Asked asked) {
  SettingOfField out = setting(member);
  out.read = [asked, read = out.read](const RenderSettings& s) {
    return asked(s) ? read(s) : std::nullopt;
  };
  return out;
}

Field with_default(Field field) {
  field.fallback = field.setting.read(RenderSettings());
  return field;
}

Field method_field() {
  Field field{.path = "method",
              .type = FieldType::kChoice,
              .help =
                  "How directions are chosen: none traces paths plainly, the others learn where "
                  "light comes from.",
              .label = "Method",
              .callers = kEverywhere,
              .setting = setting([](RenderSettings & s) -> auto& { return s.method; })};
  for (std::string_view name : method_names()) {
    Choice choice{std::string(name)};
    for (const auto& [method, label] : kMethodLabels)
      if (method == name) choice.label = label;
    field.choices.push_back(std::move(choice));
  }
  return with_default(std::move(field));
}

Field pixels_field() {
  return {.path = "pixels",
          .type = FieldType::kChoice,
          .help =
              "Which are sampled: all, one of each 2 x 2 (quarter), or those, more often where "
              "they are noisy (adaptive). For all but the first, width and height must be even.",
          .label = "Pixels",
          .choices = {{"all"}, {"quarter", "a quarter"}, {"adaptive", "a quarter, adaptive"}},
          .fallback = FieldValue("all"),
          .callers = kEverywhere,
          .setting = {[](RenderSettings& s, const FieldValue& value) {
                        if (const auto named = pixels_named(std::get<std::string>(value)))
                          s.pixels = *named;
                      },
                      [](const RenderSettings& s) -> std::optional<FieldValue> {
                        return FieldValue(std::string(pixels_name(s.pixels)));
                      }}};
}

Field recover_field() {
  return with_default(
      {.path = "recover",
       .type = FieldType::kChoice,
       .help = "What makes the picture whole: none, bilinear interpolation, a network that is "
               "included (default, untrained), auto (the scene's own network, else the default "
               "one), or weights.",
       .label = "Recover",
       .choices = {{"none", "no", kEverywhere & ~kLive},
                   {"auto", "automatic", kEverywhere & ~kVariant},
                   {"bilinear", "", kEverywhere & ~kLive},
                   {"untrained"},
                   {"default", "default network"}},
       .other = "the id of weights (32 hex digits)",
       .callers = kEverywhere,
       .setting = setting([](RenderSettings & s) -> auto& { return s.recover; })});
}

void add_job(FieldTable& out) {
  out.push_back({.path = "scene",
                 .type = FieldType::kName,
                 .required = true,
                 .help = "The name of a scene of the server's, or of an uploaded one.",
                 .label = "Scene",
                 .callers = kJob | kLive});
  out.push_back({.path = "width",
                 .help = "Of the picture; " + kScenes + ".",
                 .label = "Width",
                 .unit = "pixels",
                 .least = 1,
                 .most = kMaxSidePx,
                 .callers = kJob | kLive,  // the command's --size gives both sides
                 .setting = setting([](RenderSettings & s) -> auto& { return s.width; })});
  out.push_back({.path = "height",
                 .help = "Of the picture; " + kScenes + ".",
                 .label = "Height",
                 .unit = "pixels",
                 .least = 1,
                 .most = kMaxSidePx,
                 .callers = kJob | kLive,
                 .setting = setting([](RenderSettings & s) -> auto& { return s.height; })});
  out.push_back(method_field());
  out.push_back(
      with_default({.path = "nee",
                    .type = FieldType::kSwitch,
                    .help = "Direct light sampling (next event estimation).",
                    .label = "Sample lights directly (nee)",
                    .callers = kOfJobs | kVariant,
                    .setting = setting([](RenderSettings & s) -> auto& { return s.nee; })}));
  out.push_back({.path = "samples",
                 .help = "Of each sampled pixel, those of learning counted; or seconds. Without "
                         "either, and without noise, 64.",
                 .label = "Samples",
                 .unit = "samples a pixel",
                 .least = 1,
                 .most = kMaxSamples,
                 .callers = kOfJobs,
                 .option = "--spp",
                 .setting = setting_if(
                     [](RenderSettings & s) -> auto& { return s.samples; },
                     [](const RenderSettings& s) { return s.samples != 0 || s.seconds == 0; })});
  out.push_back({.path = "seconds",
                 .type = FieldType::kNumber,
                 .help = "Of rendering, instead of samples.",
                 .label = "Seconds",
                 .unit = "s",
                 .most = kMaxSeconds,
                 .above_least = true,
                 .callers = kOfJobs,
                 .setting = setting_if(
                     [](RenderSettings & s) -> auto& { return s.seconds; },
                     [](const RenderSettings& s) { return s.seconds != 0; })});
  out.push_back({.path = "noise",
                 .type = FieldType::kNumber,
                 .help = "Stop when the picture's relative error, as its own samples tell it, is "
                         "that low; samples or seconds bound it, 3600 s if neither is given.",
                 .label = "Stop at noise",
                 .most = 1,
                 .above_least = true,
                 .callers = kOfJobs,
                 .setting = setting_if(
                     [](RenderSettings & s) -> auto& { return s.noise; },
                     [](const RenderSettings& s) { return s.noise != 0; })});
  out.push_back(
      with_default({.path = "seed",
                    .type = FieldType::kWhole64,
                    .help = "Of the random numbers: the same seed gives the same picture.",
                    .label = "Seed",
                    .callers = kOfJobs | kLive,
                    .setting = setting([](RenderSettings & s) -> auto& { return s.seed; })}));
  out.push_back({.path = "table",
                 .type = FieldType::kChoice,
                 .help = "What to start from: auto (the newest table of the same method, geometry, "
                         "materials and lights), none (neither used nor saved), or a table.",
                 .label = "Table",
                 .choices = {{"auto", "automatic"}, {"none"}},
                 .other = "the id of a table (32 hex digits)",
                 .fallback = FieldValue("auto"),
                 .callers = kOfServer | kLive});
  out.push_back(pixels_field());
  out.push_back(recover_field());
}

void add_renderer(FieldTable& out) {
  out.push_back({.path = "max_depth",
                 .help = "Surfaces on a path, at most; " + kScenes + ".",
                 .label = "Longest path",
                 .unit = "surfaces",
                 .least = 1,
                 .most = 128,
                 .callers = kEverywhere,
                 .key = "depth",
                 .setting = setting([](RenderSettings & s) -> auto& { return s.max_depth; })});
  out.push_back(with_default(
      {.path = "learning_samples",
       .help = "That the guide learns from, at most; never over a quarter of the job's.",
       .label = "Learning samples",
       .unit = "samples a pixel",
       .most = kMaxSamples,
       .callers = kOfJobs | kVariant,
       .key = "learning",
       .setting = setting([](RenderSettings & s) -> auto& { return s.learning_samples; })}));
  out.push_back(with_default(
      {.path = "gate",
       .type = FieldType::kSwitch,
       .help = "A guide that does not pay is left; without the gate it rules regardless.",
       .label = "Leave a guide that does not pay (gate)",
       .callers = kOfJobs | kVariant,
       .setting = setting([](RenderSettings & s) -> auto& { return s.gate; })}));
  out.push_back(with_default(
      {.path = "russian_roulette",
       .type = FieldType::kSwitch,
       .help = "Dim paths are ended at random.",
       .callers = kVariant,
       .key = "roulette",
       .setting = setting([](RenderSettings & s) -> auto& { return s.russian_roulette; })}));
  out.push_back(with_default(
      {.path = "light_table",
       .type = FieldType::kSwitch,
       .help = "Lights are picked by their power, else all alike.",
       .callers = kVariant,
       .setting = setting([](RenderSettings & s) -> auto& { return s.light_table; })}));
}

template <class Member>
Field guide_setting(std::string name, std::vector<std::string> methods, std::string help,
                    std::string label, std::pair<double, double> range, Member member) {
  using T = std::remove_cvref_t<decltype(member(std::declval<RenderSettings&>()))>;
  return with_default({.path = "guide/" + std::move(name),
                       .type = std::is_same_v<T, int> ? FieldType::kWhole : FieldType::kNumber,
                       .help = std::move(help),
                       .label = std::move(label),
                       .least = range.first,
                       .most = range.second,
                       .callers = kOfServer | kRender | kVariant,
                       .methods = std::move(methods),
                       .setting = setting(member)});
}

void add_guides(FieldTable& out) {
  const std::vector<std::string> huang{"huang", "huang-published"}, adaptive{"adaptive"};
  out.push_back(guide_setting(
      "alpha", huang, "Learning rate.", "Alpha", {0, 1},
      [](RenderSettings & s) -> auto& { return s.huang.alpha; }));
  out.push_back(guide_setting(
      "gamma", huang, "Discount of what comes later.", "Gamma", {0, 1},
      [](RenderSettings & s) -> auto& { return s.huang.gamma; }));
  out.push_back(guide_setting(
      "grid", {"huang", "huang-published", "dahm-keller"},
      "Cells along the scene's longest side, about.", "Grid", {1, SurfaceGrid::kMaxGrid},
      [](RenderSettings & s) -> auto& { return s.huang.grid; }));
  out.push_back(guide_setting(
      "split", adaptive, "A place that was hit by more samples in a pass is cut in two.",
      "Samples that cut a place", {1, 1e9},
      [](RenderSettings & s) -> auto& { return s.adaptive.split_samples; }));
  out.push_back(guide_setting(
      "keep", adaptive, "The part of what earlier passes learned that each pass keeps.",
      "Kept each pass", {0, 1}, [](RenderSettings & s) -> auto& { return s.adaptive.keep; }));
  out.push_back(guide_setting(
      "uniform", adaptive, "The part of each place's density that is uniform, about.",
      "Uniform part", {0, 1}, [](RenderSettings & s) -> auto& { return s.adaptive.uniform; }));
  out.push_back(guide_setting(
      "min_gain", adaptive,
      "A place whose directions gain less in variance draws from the BSDF alone.", "Least gain",
      {0, 1e6}, [](RenderSettings & s) -> auto& { return s.adaptive.min_gain; }));
  out.push_back(guide_setting(
      "glossy", adaptive, "The chance to draw from the guide on a surface that is not diffuse.",
      "Guided on glossy surfaces", {0, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.glossy; }));
  out.push_back(guide_setting(
      "shrinkage", adaptive,
      "Of the directions' cells toward the estimate of the cell around them, in samples.",
      "Shrinkage", {0, 1e6},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.shrinkage; }));
  out.push_back(guide_setting(
      "share", adaptive,
      "A cell of directions with a larger part of what arrives at its place is cut in four.",
      "Share that cuts a cell", {0, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.split_share; }));
  out.push_back(guide_setting(
      "split_gain", adaptive,
      "By how much such a cut must raise the density's second moment, as a part of it.",
      "Least gain of a cut", {-1, 1},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.min_split_gain; }));
  out.push_back(guide_setting(
      "levels", adaptive, "How often a cell of directions may be cut.", "Levels", {0, 12},
      [](RenderSettings & s) -> auto& { return s.adaptive.direction.max_depth; }));
}

Field camera_field(std::string name, FieldType type, std::string help, std::string label,
                   std::string unit, std::pair<double, double> range) {
  return {.path = "camera/" + std::move(name),
          .type = type,
          .help = std::move(help) + "; " + kScenes + ".",
          .label = std::move(label),
          .unit = std::move(unit),
          .least = range.first,
          .most = range.second,
          .callers = kOfJobs | kLive};
}

// How they reach the settings: camera_of(), as they are judged together.
void add_camera(FieldTable& out) {
  const std::pair space{-kMaxLengthM, kMaxLengthM}, length{0.0, kMaxLengthM};
  out.push_back(
      camera_field("position", FieldType::kVector, "Where the camera is", "Camera at", "m", space));
  out.push_back(camera_field("target", FieldType::kVector, "The point that it looks at",
                             "Looking at", "m", space));
  out.push_back(camera_field("up", FieldType::kVector, "The direction that is up in the picture",
                             "Up", "", space));
  out.push_back(camera_field("vertical_fov_deg", FieldType::kNumber,
                             "The angle from the picture's lower side to its upper one",
                             "Field of view", "degrees", {0.1, 179}));
  out.push_back(camera_field("aperture_radius", FieldType::kNumber,
                             "Of the lens; 0 makes all sharp", "Aperture radius", "m", length));
  out.push_back(camera_field("focus_distance", FieldType::kNumber,
                             "At which all is sharp, along the view; 0 is the target's",
                             "Focus distance", "m", length));
}

void add_queue(FieldTable& out) {
  out.push_back({.path = "priority",
                 .help = "Each step is twice the share of the machine, and a minute in the queue.",
                 .label = "Priority",
                 .least = -5,
                 .most = 5,
                 .fallback = FieldValue(int64_t{0}),
                 .callers = kOfServer});
  out.push_back({.path = "labels",
                 .type = FieldType::kLabels,
                 .help = "Texts of the client's own by name, to find the job by.",
                 .label = "Labels",
                 .callers = kOfServer,
                 .option = "--label"});
}

FieldTable make_job_fields() {
  FieldTable out;
  add_job(out);
  add_renderer(out);
  add_guides(out);
  add_camera(out);
  add_queue(out);
  return out;
}

Field session_switch(std::string name, std::string help) {
  return {.path = std::move(name),
          .type = FieldType::kSwitch,
          .help = std::move(help),
          .fallback = FieldValue(true),
          .callers = kLive};
}

FieldTable make_live_fields() {
  FieldTable out;
  for (const Field& field : job_fields()) {
    if (!(field.callers & kLive)) continue;
    Field own = field;
    if (own.path == "width" || own.path == "height") own.least = own.multiple_of = 2;
    if (own.path == "pixels") own.fallback = FieldValue("adaptive");
    if (own.path == "recover") own.fallback = FieldValue("auto");
    out.push_back(std::move(own));
  }
  out.push_back({.path = "frame_ms",
                 .type = FieldType::kNumber,
                 .help = "The time that a frame may take.",
                 .unit = "ms",
                 .least = 20,
                 .most = 2000,
                 .fallback = FieldValue(100.0),
                 .callers = kLive});
  out.push_back(session_switch("learning", "Whether the session learns where light comes from."));
  out.push_back(session_switch("recovery", "Whether a network makes frames whole."));
  out.push_back(session_switch("reprojection", "Whether frames take over what earlier ones saw."));
  return out;
}

}  // namespace

const FieldTable& job_fields() {
  static const FieldTable fields = make_job_fields();
  return fields;
}

const FieldTable& live_fields() {
  static const FieldTable fields = make_live_fields();
  return fields;
}

}  // namespace qray
