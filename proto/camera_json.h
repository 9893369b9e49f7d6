// Cameras as JSON, as requests have them: what is given and nothing else. Pure.
#pragma once

#include <nlohmann/json.hpp>

#include "core/settings/job_request.h"

namespace qray {

template <class Json>
void to_json(Json& out, const CameraRequest& camera) {
  out = Json::object();
  const auto put = [&out](const char* name, const auto& value) {
    if (value) out[name] = *value;
  };
  put("position", camera.position);
  put("target", camera.target);
  put("up", camera.up);
  put("vertical_fov_deg", camera.vertical_fov_deg);
  put("aperture_radius", camera.aperture_radius);
  put("focus_distance", camera.focus_distance);
  put("projection", camera.projection);
  put("height", camera.height);
}

template <class Json>
void to_json(Json& out, const CameraChoice& choice) {
  if (choice.name.empty())
    to_json(out, choice.camera);
  else
    out = choice.name;
}

}  // namespace qray
