#include "proto/live_messages.h"

#include "proto/scene_members.h"

namespace qray::proto {
namespace {

constexpr double kMostFactor = 1000;

void read_switches(ObjectReader& in, LiveSwitchesRequest& out) {
  in.boolean("learning", out.learning);
  in.boolean("recovery", out.recovery);
  in.boolean("reprojection", out.reprojection);
}

void read_camera_member(ObjectReader& in, CameraRequest& out, std::vector<FieldError>& errors) {
  const Json* camera = in.find("camera");
  if (camera && camera->is_object()) {
    read_camera(*camera, out, errors);
  } else {
    in.wrong("camera", "expected an object, got " + (camera ? shown(*camera) : "nothing"));
  }
}

void read_side(ObjectReader& in, const char* name, int most, std::optional<int>& out) {
  in.integer(name, 2, most, out);
  if (out && *out % 2 != 0) in.wrong(name, "expected an even number, got " + std::to_string(*out));
}

void read_live(const Json& tree, const RequestLimits& limits, LiveRequest& out,
               std::vector<FieldError>& errors) {
  ObjectReader in(tree, "", errors);
  read_scene(in, out.scene);
  read_side(in, "width", limits.max_dimension_px, out.width);
  read_side(in, "height", limits.max_dimension_px, out.height);
  in.number("frame_ms", kLeastFrameMs, kMostFrameMs, out.frame_ms);
  read_method(in, limits, out.method);
  in.one_of("pixels", {"all", "quarter", "adaptive"}, out.pixels);
  read_table(in, out.table);
  read_recover(in, {"auto", "untrained", "default"}, out.recover);
  in.integer("seed", uint64_t{0}, UINT64_MAX, out.seed);
  in.integer("max_depth", 1, 128, out.max_depth);
  read_switches(in, out.switches);
  if (in.find("camera")) read_camera_member(in, out.camera.emplace(), errors);
  in.refuse_unknown();
}

Json vec3_json(const std::optional<std::array<double, 3>>& v) {
  return v ? Json(*v) : Json(nullptr);
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
      [](const Json& tree, LiveCameraRequest& request, std::vector<FieldError>& errors) {
        ObjectReader in(tree, "", errors);
        in.integer("number", uint64_t{1}, UINT64_MAX, request.number);
        if (!tree.contains("number")) in.wrong("number", "expected a number, got nothing");
        read_camera_member(in, request.camera, errors);
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
        request = now;
        read_switches(in, request);
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
  const CameraRequest& c = live.camera;
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
                    {"camera",
                     {{"position", vec3_json(c.position)},
                      {"target", vec3_json(c.target)},
                      {"up", vec3_json(c.up)},
                      {"vertical_fov_deg", c.vertical_fov_deg.value_or(0)},
                      {"aperture_radius", c.aperture_radius.value_or(0)},
                      {"focus_distance", c.focus_distance.value_or(0)}}},
                    {"learning", live.switches.learning},
                    {"recovery", live.switches.recovery},
                    {"reprojection", live.switches.reprojection},
                    {"lights", live.lights},
                    {"factors", live.factors},
                    {"frames", live.frames},
                    {"readers", live.readers}};
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string live_camera_to_json(uint64_t number) { return Json{{"number", number}}.dump(); }

}  // namespace qray::proto
