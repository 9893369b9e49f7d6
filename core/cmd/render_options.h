// The options that say what to render, shared by `render` and `submit`. One thread.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/render/prepared_scene.h"
#include "core/render/settings.h"
#include "proto/client_json.h"

namespace CLI {
class App;
}

namespace qray::cmd {

struct RenderOptions {
  std::string scene;
  std::optional<std::string> method;
  bool no_nee = false;
  std::optional<int> samples, max_depth, learning_samples, grid;
  std::optional<double> seconds, noise;
  std::optional<uint64_t> seed;
  std::optional<float> alpha, gamma;
  std::string size;  // "WxH"
  std::optional<std::string> pixels, recover;
};

void add_render_options(CLI::App& app, RenderOptions& options);

// "640x480" -> {640, 480}.
Result<std::pair<int, int>> parse_size(const std::string& text);

// What is not given comes from the scene (size, depth), else from RenderSettings' defaults.
Result<RenderSettings> make_settings(const RenderOptions& options, const Scene& scene);
// What is not given is left to the server.
Result<proto::JobSubmission> make_submission(const RenderOptions& options);

}  // namespace qray::cmd
