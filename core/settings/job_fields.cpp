#include "core/settings/job_fields.h"

#include "core/settings/frames.h"
#include "core/settings/guide_fields.h"
#include "core/settings/setting_of_field.h"

namespace qray {
namespace {

constexpr unsigned kOfJobs = kJob | kRender | kSubmit;  // neither of sessions nor of charts
constexpr unsigned kOfServer = kJob | kSubmit;
constexpr int kMaxSidePx = 8192;
constexpr double kMaxSeconds = 24 * 3600;
constexpr double kMaxLengthM = 1e6;
const std::string kSceneElse = " Left out, it is the scene's.";

Field pixels_field() {
  return {
      .path = "pixels",
      .type = FieldType::kChoice,
      .help =
          "The pixels that are sampled: all, one of each block of 2 x 2 (quarter), or these, more "
          "often where they are noisy (by-noise). All but the first need an even width and height.",
      .label = "Pixels",
      .choices = {{"all"},
                  {"quarter", "a quarter"},
                  {"by-noise", "a quarter, more where it is noisy"}},
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
       .help =
           "What makes the picture whole from the sampled pixels: nothing (none), bilinear "
           "interpolation, an included network (default, untrained), the scene's own network or "
           "else the default one (auto), or weights: an id on a server, a file for qray render. "
           "qray render and qray chart know oidn too, Open Image Denoise where its library is.",
       .label = "Recover",
       .choices = {{"none", "no", kEverywhere & ~kLive},
                   {"auto", "automatic", kEverywhere & ~kVariant},
                   {"bilinear", "", kEverywhere & ~kLive},
                   {"untrained"},
                   {"default", "default network"},
                   {"oidn", "", kRender | kVariant}},
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
                 .help = "The picture's width." + kSceneElse,
                 .label = "Width",
                 .unit = "pixels",
                 .least = 1,
                 .most = kMaxSidePx,
                 .callers = kJob | kLive,  // the command's --size gives both sides
                 .setting = setting([](RenderSettings & s) -> auto& { return s.width; })});
  out.push_back({.path = "height",
                 .help = "The picture's height." + kSceneElse,
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
                    .help = "Lights are sampled directly at every surface (next event estimation).",
                    .label = "Sample lights directly (nee)",
                    .callers = kOfJobs | kVariant,
                    .setting = setting([](RenderSettings & s) -> auto& { return s.nee; })}));
  out.push_back({.path = "samples",
                 .help = "The samples of each sampled pixel, those of learning included. Without "
                         "samples, seconds and noise it is 64.",
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
                 .help = "The time of rendering, instead of samples.",
                 .label = "Seconds",
                 .unit = "s",
                 .most = kMaxSeconds,
                 .above_least = true,
                 .callers = kOfJobs,
                 .setting = setting_if(
                     [](RenderSettings & s) -> auto& { return s.seconds; },
                     [](const RenderSettings& s) { return s.seconds != 0; })});
  out.push_back(
      {.path = "noise",
       .type = FieldType::kNumber,
       .help = "Rendering stops when the picture's relative error, as its own samples tell it, is "
               "this low. Samples or seconds bound it; if neither is given, 3600 s do.",
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
                    .help = "The seed of the random numbers. The same request with the same seed "
                            "gives the same picture, unless time bounds it.",
                    .label = "Seed",
                    .callers = kOfJobs | kLive,
                    .setting = setting([](RenderSettings & s) -> auto& { return s.seed; })}));
  out.push_back(
      {.path = "table",
       .type = FieldType::kChoice,
       .help = "The table to start from: of those of the same method, geometry, materials and "
               "lights the one that has seen the most (auto), none, which saves none either, or "
               "one by its id.",
       .label = "Table",
       .choices = {{"auto", "automatic"}, {"none"}},
       .other = "the id of a table (32 hex digits)",
       .fallback = FieldValue("auto"),
       .callers = kOfServer | kLive});
  out.push_back(pixels_field());
  out.push_back(recover_field());
}

template <class Member>
Field region_field(std::string name, std::string label, std::string help, double least,
                   Member member) {
  return {.path = "region/" + std::move(name),
          .help = std::move(help),
          .label = std::move(label),
          .unit = "pixels",
          .least = least,
          .most = kMaxSidePx,
          .callers = kOfJobs,
          .setting = setting_if(member, [member](const RenderSettings& s) {
            return member(const_cast<RenderSettings&>(s)) != 0;
          })};
}

void add_region(FieldTable& out) {
  out.push_back(region_field(
      "x", "Region first: from the left",
      "The left edge of the region that gets its samples first: all of them, or half of the job's "
      "where time or noise ends it.",
      0, [](RenderSettings & s) -> auto& { return s.region.x; }));
  out.push_back(region_field(
      "y", "Region first: from the top", "The upper edge of that region.", 0,
      [](RenderSettings & s) -> auto& { return s.region.y; }));
  out.push_back(region_field(
      "width", "Region first: width", "The width of that region.", 1,
      [](RenderSettings & s) -> auto& { return s.region.width; }));
  out.push_back(region_field(
      "height", "Region first: height", "The height of that region.", 1,
      [](RenderSettings & s) -> auto& { return s.region.height; }));
}

// What is kept and made beside the picture.
void add_passes(FieldTable& out) {
  Field passes{.path = "passes",
               .type = FieldType::kNames,
               .help = "What is made beside the picture, as layers of one EXR (docs/passes.md).",
               .label = "Passes",
               .callers = kOfJobs,
               .setting = {[](RenderSettings& s, const FieldValue& value) {
                             s.picture_passes = {};
                             for (const std::string& name : std::get<Names>(value))
                               (void)s.picture_passes.add(name);
                           },
                           {}}};
  passes.choices.push_back({"all"});
  for (const std::string_view name : kPicturePassNames)
    passes.choices.push_back({std::string(name)});
  out.push_back(std::move(passes));
  Field groups{
      .path = "light_groups",
      .type = FieldType::kChoice,
      .help =
          "Which lights are one group, whose light is kept apart so that it can be mixed "
          "afterwards: those that the scene gives one name (scene), those of one material or "
          "of one name of a mesh, or each its own. At most 64 groups. Left out, none are kept.",
      .label = "Groups of lights",
      .callers = kOfJobs,
      .setting = {[](RenderSettings& s, const FieldValue& value) {
                    if (const auto named = light_grouping_named(std::get<std::string>(value)))
                      s.light_groups = *named;
                  },
                  {}}};
  for (const std::string_view name : kLightGroupingNames)
    groups.choices.push_back({std::string(name)});
  out.push_back(std::move(groups));
  out.push_back({.path = "mix",
                 .type = FieldType::kText,
                 .help = "Factors of the light of the groups, in their order: such as 1;0;2,1.5,1, "
                         "which leaves the first as it is, switches the second off, and doubles "
                         "the third's red. The scene is lit so. It needs light_groups.",
                 .callers = kOfJobs,
                 .setting = setting_if(
                     [](RenderSettings & s) -> auto& { return s.mix; },
                     [](const RenderSettings& s) { return !s.mix.empty(); })});
}

void add_renderer(FieldTable& out) {
  out.push_back({.path = "max_depth",
                 .help = "The most surfaces that a path meets." + kSceneElse,
                 .label = "Longest path",
                 .unit = "surfaces",
                 .least = 1,
                 .most = 128,
                 .callers = kEverywhere,
                 .key = "depth",
                 .setting = setting([](RenderSettings & s) -> auto& { return s.max_depth; })});
  out.push_back(with_default(
      {.path = "learning_samples",
       .help = "The most samples that the guide learns from. It never learns from more than "
               "half of the job's.",
       .label = "Learning samples",
       .unit = "samples a pixel",
       .most = kMaxSamples,
       .callers = kOfJobs | kVariant,
       .key = "learning",
       .setting = setting([](RenderSettings & s) -> auto& { return s.learning_samples; })}));
  out.push_back(with_default(
      {.path = "gate",
       .type = FieldType::kSwitch,
       .help = "The job leaves a guide that does not pay. Without the gate it is used regardless.",
       .label = "Leave a guide that does not pay (gate)",
       .callers = kOfJobs | kVariant,
       .setting = setting([](RenderSettings & s) -> auto& { return s.gate; })}));
  out.push_back(with_default(
      {.path = "russian_roulette",
       .type = FieldType::kSwitch,
       .help = "Dim paths are ended at random (Russian roulette).",
       .callers = kVariant,
       .key = "roulette",
       .setting = setting([](RenderSettings & s) -> auto& { return s.russian_roulette; })}));
  out.push_back(with_default(
      {.path = "light_table",
       .type = FieldType::kSwitch,
       .help = "Many lights are picked by what they send to the place, few by their power. Without "
               "it all "
               "are picked alike.",
       .callers = kVariant,
       .setting = setting([](RenderSettings & s) -> auto& { return s.light_table; })}));
}

Field camera_field(std::string name, FieldType type, std::string help, std::string label,
                   std::string unit, std::pair<double, double> range) {
  return {.path = "camera/" + std::move(name),
          .type = type,
          .help = std::move(help) + kSceneElse,
          .label = std::move(label),
          .unit = std::move(unit),
          .least = range.first,
          .most = range.second,
          .callers = kOfJobs | kLive};
}

// How they reach the settings: camera_of(), as they are judged together.
void add_camera(FieldTable& out) {
  const std::pair space{-kMaxLengthM, kMaxLengthM}, length{0.0, kMaxLengthM};
  out.push_back(camera_field("position", FieldType::kVector, "The point where the camera is.",
                             "Camera at", "m", space));
  out.push_back(camera_field("target", FieldType::kVector, "The point that the camera looks at.",
                             "Looking at", "m", space));
  out.push_back(camera_field("up", FieldType::kVector, "The direction that is up in the picture.",
                             "Up", "", space));
  out.push_back(camera_field("vertical_fov_deg", FieldType::kNumber,
                             "The angle from the picture's lower edge to its upper one.",
                             "Field of view", "degrees", {0.1, 179}));
  out.push_back(camera_field("aperture_radius", FieldType::kNumber,
                             "The radius of the lens. 0 makes everything sharp.", "Aperture radius",
                             "m", length));
  out.push_back(
      camera_field("focus_distance", FieldType::kNumber,
                   "The distance along the view at which everything is sharp. 0 is the target's.",
                   "Focus distance", "m", length));
  Field projection = camera_field(
      "projection", FieldType::kChoice,
      "How the picture shows the scene: in perspective, by parallel rays (orthographic), or all "
      "around (equirectangular, a picture twice as wide as high).",
      "Projection", "", {0.0, 0.0});
  for (const std::string_view name : kProjectionNames)
    projection.choices.push_back({std::string(name)});
  out.push_back(std::move(projection));
  out.push_back(camera_field("height", FieldType::kNumber,
                             "What an orthographic picture shows from its lower edge to its upper "
                             "one. 0 is what the field of view spans at the target.",
                             "Height shown", "m", length));
}

// How they become cameras: frames_of().
void add_frames(FieldTable& out) {
  const auto frames_field = [](std::string name, FieldType type, std::string help,
                               std::string label) {
    return Field{.path = "frames/" + std::move(name),
                 .type = type,
                 .help = std::move(help),
                 .label = std::move(label),
                 .least = -kMaxLengthM,
                 .most = kMaxLengthM,
                 .callers = kOfJobs,
                 .option = ""};
  };
  Field turntable = frames_field(
      "turntable", FieldType::kWhole,
      "The camera is turned about the scene, for so many frames of one job, which learn together.",
      "Turntable");
  turntable.unit = "frames";
  turntable.least = 1;
  turntable.most = kMaxFrames;
  turntable.option = "--turntable";
  out.push_back(std::move(turntable));
  Field center = frames_field(
      "center", FieldType::kVector,
      "A point of the turntable's axis. Left out, it is the camera's target.", "Turned about");
  center.unit = "m";
  center.option = "--turntable-center";
  out.push_back(std::move(center));
  Field axis = frames_field(
      "axis", FieldType::kVector,
      "The direction of the turntable's axis. Left out, it is the camera's up.", "Axis");
  axis.option = "--turntable-axis";
  out.push_back(std::move(axis));
  Field degrees = frames_field(
      "degrees", FieldType::kNumber,
      "The arc of the turntable, from the first frame to the last. Left out, it is 360, where the "
      "last frame is one step short of the first.",
      "Arc");
  degrees.unit = "degrees";
  degrees.least = -360;
  degrees.most = 360;
  degrees.option = "--turntable-degrees";
  out.push_back(std::move(degrees));
  Field cameras = frames_field(
      "cameras", FieldType::kCameras,
      "The cameras of a job of many frames, which learn together: names of the scene's own (* is "
      "each of them), or cameras as in `camera`.",
      "Cameras");
  cameras.option = "--camera";
  out.push_back(std::move(cameras));
  Field animation =
      frames_field("animation", FieldType::kNumber,
                   "The scene moves as its file says (glTF, JSON), for one job of so many frames a "
                   "second, which learn together. The camera is the scene's first, or the one that "
                   "cameras names.",
                   "Animation");
  animation.unit = "frames/s";
  animation.least = 0.01;
  animation.most = 1000;
  animation.option = "--animation";
  out.push_back(std::move(animation));
  const auto add_time = [&](const std::string& name, std::string help, std::string label) {
    Field time = frames_field(name, FieldType::kNumber, std::move(help), std::move(label));
    time.unit = "s";
    time.least = 0;
    time.option = "--animation-" + name;
    out.push_back(std::move(time));
  };
  add_time("from", "When the animation's first frame is. Left out, it is 0.", "From");
  add_time("to",
           "When the animation's last frame is, at most. Left out, it is the end of what moves.",
           "To");
  Field seeds = frames_field(
      "seeds", FieldType::kChoice,
      "The noise of frames: of each its own (independent), or the same pattern in all (one). Left "
      "out, it is independent.",
      "Noise of frames");
  seeds.choices = {{"independent"}, {"one", "one pattern"}};
  seeds.option = "--frame-seeds";
  out.push_back(std::move(seeds));
}

void add_queue(FieldTable& out) {
  out.push_back({.path = "priority",
                 .help = "Each step doubles the job's share of the machine and counts as a minute "
                         "of waiting in the queue.",
                 .label = "Priority",
                 .least = -5,
                 .most = 5,
                 .fallback = FieldValue(int64_t{0}),
                 .callers = kOfServer});
  out.push_back({.path = "alone",
                 .type = FieldType::kSwitch,
                 .help = "No other job runs on the server meanwhile, so that its time can be "
                         "compared.",
                 .label = "Run alone, to compare times",
                 .fallback = FieldValue(false),
                 .callers = kOfServer,
                 .option = "--alone"});
  out.push_back({.path = "workers",
                 .help = "The workers of a farm that sample the picture together (auto: as many as "
                         "there are). It has the bits that one makes. Left out, it is 1.",
                 .label = "Workers",
                 .least = 1,
                 .most = 1000,
                 .zero = "auto",
                 .callers = kOfServer});
  out.push_back(
      {.path = "labels",
       .type = FieldType::kLabels,
       .help = "Texts of the client's own by name, such as a project's, to find the job by.",
       .label = "Labels",
       .callers = kOfServer,
       .option = "--label"});
}

FieldTable make_job_fields() {
  FieldTable out;
  add_job(out);
  add_region(out);
  add_passes(out);
  add_renderer(out);
  for (Field& field : guide_fields()) out.push_back(std::move(field));
  add_camera(out);
  add_frames(out);
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
    if (own.path == "pixels") own.fallback = FieldValue("by-noise");
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

const FieldValue* JobRequest::default_of(std::string_view path) {
  const Field* field = find_field(job_fields(), path);
  if (!field) field = find_field(live_fields(), path);
  return field && field->fallback ? &*field->fallback : nullptr;
}

}  // namespace qray
