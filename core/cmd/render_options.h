// The options that say what to render, shared by `render` and `submit`: those of the table of job
// fields. One thread.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/scene/scene.h"
#include "core/settings/job_fields.h"

namespace CLI {
class App;
}

namespace qray::cmd {

inline constexpr int64_t kMaxPixels = int64_t{1} << 28;  // of a picture rendered here

struct RenderOptions {
  std::string scene;
  std::optional<std::string> method;  // "huang", "huang:grid=12" (variant.h)
  std::string size;                   // "WxH"
  std::string frames;                 // a file
  JobRequest given;                   // by all other options
};

// --exposure: stops from -32 to 32, or "auto".
void add_exposure_option(CLI::App& app, std::string& exposure);
// Those that the table gives `caller`: kRender or kSubmit.
void add_render_options(CLI::App& app, RenderOptions& options, unsigned caller,
                        const FieldTable& fields = job_fields());

// "640x480" -> {640, 480}.
Result<std::pair<int, int>> parse_size(const std::string& text);

// What was given and nothing else; options go before what the method's text says.
Result<JobRequest> make_request(const RenderOptions& options, unsigned caller,
                                const FieldTable& fields = job_fields());
// Of `render`. What is not given comes from the scene (size, depth, camera), else from the table.
Result<RenderSettings> make_settings(const RenderOptions& options, const Scene& scene,
                                     const FieldTable& fields = job_fields());

}  // namespace qray::cmd
