#include "core/cmd/render_options.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "core/base/file.h"
#include "core/image/exposure.h"
#include "core/settings/frames.h"
#include "core/settings/job_settings.h"
#include "core/settings/variant.h"
#include "proto/messages.h"

namespace qray::cmd {
namespace {

constexpr uint64_t kMaxFramesBytes = 1u << 20;
constexpr double kNoiseSeconds = 3600;  // that bound a picture's noise, as the server has it

std::string text_of(const FieldValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* whole = std::get_if<int64_t>(&value)) return std::to_string(*whole);
  if (const auto* whole = std::get_if<uint64_t>(&value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  return "";
}

// By its option: what it is not by default.
bool switched_to(const Field& field) { return field.fallback && !std::get<bool>(*field.fallback); }

std::string help_of(const Field& field, unsigned caller) {
  std::string out = field.help;
  if (field.type == FieldType::kSwitch) return switched_to(field) ? out : "Off: " + out;
  out += " Expects " + expected(field, caller);
  if (!field.unit.empty()) out += " (" + field.unit + ")";
  if (field.fallback) out += "; default " + text_of(*field.fallback);
  return out;
}

// Of JSON, after those before.
void add_camera(const std::string& text, const std::string& option, JobRequest& given) {
  const auto camera = proto::parse_camera(text);
  if (const auto* problem = std::get_if<proto::Problem>(&camera))
    throw CLI::ValidationError(option, problem->detail);
  Cameras cameras = given.given(field::kCameras).value_or(Cameras());
  cameras.push_back({"", std::get<CameraRequest>(camera)});
  given.set(field::kCameras, std::move(cameras));
}

void add_option(CLI::App& app, const Field& field, unsigned caller, JobRequest& given) {
  const std::string name = field.option_name(), help = help_of(field, caller);
  if (field.type == FieldType::kSwitch) {
    app.add_flag_callback(
        name,
        [&given, path = field.path, to = switched_to(field)] { given.set(path, FieldValue(to)); },
        help);
    return;
  }
  const auto take = [&given, field, caller, name](const std::vector<std::string>& texts) {
    for (const std::string& text : texts)
      if (field.type == FieldType::kCameras && text.starts_with('{')) {
        add_camera(text, name, given);
      } else if (const Status set = set_from_text(field, text, caller, given); !set.ok())
        throw CLI::ValidationError(name, set.error().message);
  };
  CLI::Option* option = app.add_option_function<std::vector<std::string>>(name, take, help);
  option->expected(1)->type_name(field.type == FieldType::kLabels ? "NAME:VALUE" : "");
  if (field.type == FieldType::kLabels || field.type == FieldType::kCameras ||
      field.type == FieldType::kNames)
    option->take_all();
  if (!field.group().empty()) option->group(std::string(field.group()));
}

}  // namespace

void add_exposure_option(CLI::App& app, std::string& exposure) {
  app.add_option("--exposure", exposure, "stops brighter, of a .png; auto: to a middle grey")
      ->check(CLI::Range(-kMaxExposure, kMaxExposure) | CLI::IsMember({"auto"}));
}

void add_render_options(CLI::App& app, RenderOptions& o, unsigned caller,
                        const FieldTable& fields) {
  app.add_option("scene", o.scene, "an included scene's name, a folder with scene.json, or a file")
      ->required();
  app.add_option("--size", o.size, "WIDTHxHEIGHT in pixels; default: the scene's");
  for (const Field& field : fields) {
    if (!(field.callers & caller)) continue;
    if (field.path == field::kMethod.path)
      app.add_option("--method", o.method,
                     field.help + " Expects " + expected(field, caller) +
                         ", also with settings: 'huang:grid=12;alpha=.1'; default " +
                         text_of(*field.fallback));
    else if (field.group() != "guide")  // which stand in --method
      add_option(app, field, caller, o.given);
  }
  app.get_option("--seconds")->excludes("--spp");
  app.add_option("--frames", o.frames,
                 "a JSON file of the frames, as a job's `frames` has them (docs/frames.md)");
}

Result<std::pair<int, int>> parse_size(const std::string& text) {
  int width = 0, height = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, height);
    if (second.ec == std::errc() && second.ptr == end && width > 0 && height > 0)
      return std::pair{width, height};
  }
  return Error{ErrorCode::kInvalid, "expected WIDTHxHEIGHT such as 640x480, got '" + text + "'",
               "--size"};
}

Result<JobRequest> make_request(const RenderOptions& o, unsigned caller, const FieldTable& fields) {
  JobRequest request;
  if (o.method) {
    // Here all that a chart may set can be set.
    Result<JobRequest> variant =
        parse_variant(*o.method, caller == kRender ? unsigned{kVariant} : caller, fields);
    if (!variant) return variant.error();
    request = std::move(variant).value();
  }
  if (!o.size.empty()) {
    const Result<std::pair<int, int>> size = parse_size(o.size);
    if (!size) return size.error();
    request.set(field::kWidth, size.value().first);
    request.set(field::kHeight, size.value().second);
  }
  if (!o.frames.empty()) {
    const Result<Bytes> text = read_file(o.frames, kMaxFramesBytes);
    if (!text) return text.error();
    const auto frames = proto::parse_frames(
        {reinterpret_cast<const char*>(text.value().data()), text.value().size()});
    if (const auto* problem = std::get_if<proto::Problem>(&frames))
      return Error{ErrorCode::kInvalid, problem->detail, o.frames};
    for (const auto& [path, value] : std::get<JobRequest>(frames).values())
      request.set(path, value);
  }
  for (const auto& [path, value] : o.given.values()) request.set(path, value);
  if (Status s = check_frames(request); !s) return s.error();
  if (!o.scene.empty()) request.set(field::kScene, o.scene);
  return request;
}

Result<RenderSettings> make_settings(const RenderOptions& o, const Scene& scene,
                                     const FieldTable& fields) {
  Result<JobRequest> request = make_request(o, kRender, fields);
  if (!request) return request.error();
  complete_budget(request.value(), kNoiseSeconds);
  return settings_of(request.value(), scene, fields);
}

}  // namespace qray::cmd
