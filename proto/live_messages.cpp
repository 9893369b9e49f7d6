#include "proto/live_messages.h"

#include "proto/field_reader.h"

namespace qray::proto {
namespace {

constexpr double kMostFactor = 1000;

// Its members were read with the rest, if there are any.
void require_camera(const Json& tree, std::vector<FieldError>& errors) {
  if (!tree.contains("camera")) errors.push_back({"/camera", "expected an object, got nothing"});
}

LiveSwitchesRequest switches_of(const JobRequest& given, const LiveSwitchesRequest& now) {
  return {given.given(field::kLearning).value_or(now.learning),
          given.given(field::kRecovery).value_or(now.recovery),
          given.given(field::kReprojection).value_or(now.reprojection)};
}

void read_live(const Json& tree, const RequestLimits& limits, LiveRequest& out,
               std::vector<FieldError>& errors) {
  JobRequest given;
  read_fields(tree, live_fields(), kLive, limits, given, errors);
  const auto put = [&](auto name, auto& member) {
    if (const auto value = given.given(name)) member = *value;
  };
  put(field::kScene, out.scene);
  put(field::kWidth, out.width);
  put(field::kHeight, out.height);
  put(field::kFrameMs, out.frame_ms);
  put(field::kMethod, out.method);
  put(field::kTable, out.table);
  put(field::kRecover, out.recover);
  put(field::kPixels, out.pixels);
  put(field::kSeed, out.seed);
  put(field::kMaxDepth, out.max_depth);
  out.camera = camera_request(given);
  out.switches = switches_of(given, {});
}

Json vec3_json(const std::optional<Vector3>& v) { return v ? Json(*v) : Json(nullptr); }

Json camera_json(const CameraRequest& c) {
  return {{"position", vec3_json(c.position)},
          {"target", vec3_json(c.target)},
          {"up", vec3_json(c.up)},
          {"vertical_fov_deg", c.vertical_fov_deg.value_or(0)},
          {"aperture_radius", c.aperture_radius.value_or(0)},
          {"focus_distance", c.focus_distance.value_or(0)},
          {"projection", c.projection.value_or("")},
          {"height", c.height.value_or(0)}};
}

}  // namespace

std::variant<LiveRequest, Problem> parse_live_request(std::string_view json,
                                                      const RequestLimits& limits) {
  return parse_request<LiveRequest>(
      json, limits, "Wrong live request",
      [&](const Json& tree, LiveRequest& request, std::vector<FieldError>& errors) {
        read_live(tree, limits, request, errors);
      });
}

std::variant<LiveCameraRequest, Problem> parse_live_camera(std::string_view json,
                                                           const RequestLimits& limits) {
  return parse_request<LiveCameraRequest>(
      json, limits, "Wrong camera",
      [&](const Json& tree, LiveCameraRequest& request, std::vector<FieldError>& errors) {
        ObjectReader in(tree, "", errors);
        in.integer("number", uint64_t{1}, UINT64_MAX, request.number);
        if (!tree.contains("number")) in.wrong("number", "expected a number, got nothing");
        JobRequest given;
        read_group(in, "camera", live_fields(), kLive, limits, given, errors);
        require_camera(tree, errors);
        in.boolean("walls", request.walls);
        request.camera = camera_request(given).value_or(CameraRequest());
        in.refuse_unknown();
      });
}

std::variant<LiveSwitchesRequest, Problem> parse_live_switches(std::string_view json,
                                                               const RequestLimits& limits,
                                                               const LiveSwitchesRequest& now) {
  return parse_request<LiveSwitchesRequest>(
      json, limits, "Wrong switches",
      [&](const Json& tree, LiveSwitchesRequest& request, std::vector<FieldError>& errors) {
        ObjectReader in(tree, "", errors);
        JobRequest given;
        for (const std::string_view path :
             {field::kLearning.path, field::kRecovery.path, field::kReprojection.path})
          read_field(in, *find_field(live_fields(), path), kLive, limits, given);
        request = switches_of(given, now);
        in.refuse_unknown();
      });
}

std::variant<std::vector<double>, Problem> parse_live_lights(std::string_view json,
                                                             const RequestLimits& limits,
                                                             size_t lights) {
  return parse_request<std::vector<double>>(
      json, limits, "Wrong lights",
      [&](const Json& tree, std::vector<double>& factors, std::vector<FieldError>& errors) {
        ObjectReader in(tree, "", errors);
        const Json* list = in.find("factors");
        if (!list || !list->is_array() || list->size() != lights) {
          in.wrong("factors", "expected " + std::to_string(lights) + " numbers, got " +
                                  (!list              ? "nothing"
                                   : list->is_array() ? std::to_string(list->size())
                                                      : shown(*list)));
        } else {
          for (size_t i = 0; i < lights; ++i) {
            const Json& item = (*list)[i];
            factors.push_back(item.is_number() ? item.get<double>() : NAN);
            if (!(factors.back() >= 0 && factors.back() <= kMostFactor))
              in.wrong(
                  "factors/" + std::to_string(i),
                  "expected a number, 0.." + number_text(kMostFactor) + ", got " + shown(item));
          }
        }
        in.refuse_unknown();
      });
}

std::string live_to_json(const LiveInfo& live) {
  Json cameras = Json::array();
  for (const auto& [name, camera] : live.cameras)
    cameras.push_back({{"name", name}, {"camera", camera_json(camera)}});
  const Json out = {{"id", live.id},
                    {"scene", live.scene},
                    {"method", live.method},
                    {"pixels", live.pixels},
                    {"recover", live.recover},
                    {"table_in", live.table_in.empty() ? Json(nullptr) : Json(live.table_in)},
                    {"width", live.width},
                    {"height", live.height},
                    {"frame_ms", live.frame_ms},
                    {"camera_number", live.camera_number},
                    {"camera", camera_json(live.camera)},
                    {"cameras", cameras},
                    {"learning", live.switches.learning},
                    {"recovery", live.switches.recovery},
                    {"reprojection", live.switches.reprojection},
                    {"lights", live.lights},
                    {"factors", live.factors},
                    {"mix", live.mix},
                    {"frames", live.frames},
                    {"readers", live.readers}};
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string live_camera_to_json(const LiveCameraAnswer& answer) {
  return Json{{"number", answer.number}, {"position", vec3_json(answer.position)}}.dump();
}

}  // namespace qray::proto
